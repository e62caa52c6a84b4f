#include "common/dds/endpoint.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include <dds/ddsi/ddsi_serdata.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include "common/dds/topics.h"
#include "tests/common/dds/own_topic.h"
#include "tests/common/dds/peer.h"
#include "tests/support/eventually.h"
#include "tests/support/roudi.h"

namespace palpate::dds {
namespace {

using std::chrono::milliseconds;

const int kForeignDomain = test::OwnDomain();
const TransportChoice kShm{Transport::kSharedMemory, ""};

struct Taken {
  std::vector<wire::HapticPose> poses;
  int through_shared_memory = 0;
};

/// Takes what there is as DDS received it: only then does a sample tell how it came.
void TakeRaw(const Reader<wire::HapticPose>& reader, Taken& taken) {
  ddsi_serdata* data[1] = {nullptr};
  dds_sample_info_t info;
  while (dds_takecdr(reader.handle(), data, 1, &info, DDS_ANY_STATE) == 1) {
    if (info.valid_data) {
      taken.through_shared_memory += data[0]->iox_chunk != nullptr;
      wire::HapticPose pose;
      ddsi_serdata_to_sample(data[0], &pose, nullptr, nullptr);
      taken.poses.push_back(pose);
    }
    ddsi_serdata_unref(data[0]);
  }
}

constexpr std::size_t kSamples = 300;  // more than the 257 chunks that a reader can lose

/// Lets the peer write kSamples, taking each before the next is written: none can be overwritten,
/// so none may be missing.
Taken TakeInStep(const Reader<wire::HapticPose>& reader, Peer& peer) {
  Taken taken;
  for (std::size_t i = 1; i <= kSamples; ++i) {
    if (!peer.Next() || !test::Eventually([&] {
          TakeRaw(reader, taken);
          return taken.poses.size() >= i;
        })) {
      ADD_FAILURE() << "sample " << i << " is missing";
      return taken;
    }
  }
  EXPECT_EQ(taken.poses.size(), kSamples) << "each once";
  return taken;
}

/// Each sample is as the peer made it; none comes twice or out of order.
void ExpectWhole(const std::vector<wire::HapticPose>& poses) {
  std::uint64_t last = 0;
  for (const wire::HapticPose& pose : poses) {
    EXPECT_GT(pose.pose_sequence, last);
    last = pose.pose_sequence;
    const double i = static_cast<double>(last);
    EXPECT_EQ(pose.sample_time_ns, static_cast<std::int64_t>(last));
    EXPECT_THAT(pose.position_m, testing::Each(i));
    EXPECT_THAT(pose.orientation_wxyz, testing::Each(i));
    EXPECT_EQ(pose.device_status, last);
  }
}

TEST(LoopTopicOverUdp, BringsWholeSamplesAndNoneThroughSharedMemory) {
  const Participant participant = Participant::Loop(kDomain, kUdp);
  const std::string topic = OwnTopic("udp");
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop);
  EXPECT_FALSE(reader.uses_shared_memory());
  Peer peer("udp", kDomain, topic, kSamples, "matched-in-step");
  const Taken taken = TakeInStep(reader, peer);
  ExpectWhole(taken.poses);
  EXPECT_EQ(taken.through_shared_memory, 0);
}

/// Returns how many of `count` samples arrive of which none is read until all are written.
std::size_t ArriveAtOnce(const Network& network, int count) {
  const Participant participant = Participant::Loop(kDomain, kUdp, network);
  const std::string topic = OwnTopic("flood");
  std::atomic<std::size_t> arrived{0};
  std::mutex busy;
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kRecord,
                                        [&](const wire::HapticPose&) {
                                          const std::lock_guard lock(busy);
                                          ++arrived;
                                        });
  Peer peer("udp", kDomain, topic, count, "matched-in-step");
  {
    const std::lock_guard lock(busy);
    for (int i = 0; i < count; ++i) EXPECT_TRUE(peer.Next());
  }
  // What was written is in the socket, or lost.
  for (std::size_t before = ~std::size_t{0}; arrived != before;) {
    before = arrived;
    std::this_thread::sleep_for(milliseconds(200));
  }
  peer.End();
  return arrived;
}

TEST(LoopTopicOverUdp, LosesNoSampleOfABusyReaderWithRoomForThem) {
  long long most = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  if (most < 4 << 20) GTEST_SKIP() << "net.core.rmem_max is " << most;
  constexpr int kFlood = 3500;  // of 0.8 to 1.3 kB each, as the kernel counts
  EXPECT_LT(ArriveAtOnce({}, kFlood), 3500u);
  EXPECT_EQ(ArriveAtOnce({.receive_buffer = 16 << 20}, kFlood), 3500u);
}

class RouDiLoopTopic : public testing::Test {
 protected:
  RouDi roudi;
  const Participant participant = Participant::Loop(kDomain, kShm);
  const std::string topic = OwnTopic(testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(RouDiLoopTopic, BringsEverySampleThroughSharedMemory) {
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop);
  EXPECT_TRUE(reader.uses_shared_memory());
  Peer peer("shm", kDomain, topic, kSamples, "matched-in-step");
  const Taken taken = TakeInStep(reader, peer);
  ExpectWhole(taken.poses);
  EXPECT_EQ(taken.through_shared_memory, static_cast<int>(taken.poses.size()));
}

TEST_F(RouDiLoopTopic, HandsEachSampleToTheCallbackOnce) {
  std::vector<wire::HapticPose> poses;
  std::atomic<std::size_t> handed{0};
  Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop,
                                  [&](const wire::HapticPose& pose) {
                                    poses.push_back(pose);
                                    handed = poses.size();
                                  });
  Peer peer("shm", kDomain, topic, kSamples, "matched-in-step");
  for (std::size_t i = 1; i <= kSamples; ++i) {
    ASSERT_TRUE(peer.Next());
    ASSERT_TRUE(test::Eventually([&] { return handed >= i; })) << i;
  }
  peer.Wait();
  reader = Reader<wire::HapticPose>();  // no callback runs any more
  EXPECT_EQ(poses.size(), kSamples);
  ExpectWhole(poses);
}

TEST_F(RouDiLoopTopic, IsNotReachedNorWornOutByAnotherDomainsWriter) {
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop);
  Peer foreign("shm", kForeignDomain, topic, 2 * kSamples, "in-step");
  for (std::size_t i = 0; i < 2 * kSamples; ++i) ASSERT_TRUE(foreign.Next());
  Taken taken;
  TakeRaw(reader, taken);
  EXPECT_EQ(taken.poses.size(), 0u);

  // The foreign writer's chunks, leaked, would have disabled the reader for good.
  Peer own("shm", kDomain, topic, kSamples, "matched-in-step");
  ExpectWhole(TakeInStep(reader, own).poses);
  TakeRaw(reader, taken);
  EXPECT_EQ(taken.poses.size(), 0u) << "nor later";
}

TEST_F(RouDiLoopTopic, SurvivesAWriterThatBeginsBeforeItIsDiscovered) {
  Peer peer("shm", kDomain, topic, 1'000'000, "in-step");
  ASSERT_TRUE(peer.Next());
  ASSERT_TRUE(test::Eventually([&] { return WriterDiscovered(participant, topic); }));
  // More than 256 samples go by before the reader is made, and the rest must reach it.
  for (std::size_t i = 0; i < kSamples; ++i) ASSERT_TRUE(peer.Next());
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop);
  // The writer does not know the reader until the first sample comes.
  Taken first;
  std::uint64_t written = 1 + kSamples;
  ASSERT_TRUE(test::Eventually([&] {
    written += peer.Next();
    TakeRaw(reader, first);
    return !first.poses.empty();
  }));
  ASSERT_TRUE(test::Eventually([&] {
    TakeRaw(reader, first);
    return first.poses.back().pose_sequence == written;
  }));
  EXPECT_GT(first.poses.back().pose_sequence, kSamples);
  const Taken taken = TakeInStep(reader, peer);
  ExpectWhole(taken.poses);
  EXPECT_EQ(taken.through_shared_memory, static_cast<int>(taken.poses.size()));
}

TEST_F(RouDiLoopTopic, GoesOverUdpWhereRouDiHasGoneSinceTheDomainWasMade) {
  EXPECT_FALSE(participant.shared_memory_lost());
  roudi.Kill();
  EXPECT_TRUE(participant.shared_memory_lost());
  // Over shared memory, making the reader would abort this process.
  const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop);
  EXPECT_FALSE(reader.uses_shared_memory());
  Peer peer("udp", kDomain, topic, kSamples, "matched-in-step");
  ExpectWhole(TakeInStep(reader, peer).poses);
}

TEST(WriterDiscovered, ForgetsAWriterThatIsGone) {
  const Participant participant = Participant::Loop(kDomain, kUdp);
  const std::string topic = OwnTopic("gone");
  EXPECT_FALSE(WriterDiscovered(participant, topic));
  {
    const Writer<wire::HapticPose> writer(participant, topic, Qos::kLoop);
    EXPECT_TRUE(WriterDiscovered(participant, topic));
    EXPECT_FALSE(WriterDiscovered(participant, topic + "2"));
  }
  EXPECT_FALSE(WriterDiscovered(participant, topic));
}

TEST(WriterDiscovered, SeesAnotherProcess) {
  const Participant participant = Participant::Loop(kDomain, kUdp);
  const std::string topic = OwnTopic("other_process");
  Peer peer("udp", kDomain, topic, 1, "in-step");
  EXPECT_TRUE(test::Eventually([&] { return WriterDiscovered(participant, topic); }));
  EXPECT_EQ(peer.Wait(), 0);
  EXPECT_TRUE(test::Eventually([&] { return !WriterDiscovered(participant, topic); }));
}

TEST(SessionTopic, TellsALateComerWhatHoldsNow) {
  const Participant server = Participant::Service(kDomain);
  Writer<wire::SessionState> writer(server, OwnTopic("state"), Qos::kSession);
  for (const char* station : {"left", "right"}) {
    for (const auto phase : {palpate_SESSION_WAITING, palpate_SESSION_ACTIVE}) {
      wire::SessionState state{};
      wire::FromText(station, state.station);
      state.phase = phase;
      ASSERT_TRUE(writer.Write(state));
    }
  }
  const Participant viewer = Participant::Service(kDomain);
  Reader<wire::SessionState> reader(viewer, OwnTopic("state"), Qos::kSession);
  std::vector<std::string> heard;
  EXPECT_TRUE(test::Eventually([&] {
    wire::SessionState state;
    while (reader.Take(state)) {
      EXPECT_EQ(state.phase, palpate_SESSION_ACTIVE);  // only the latest
      heard.push_back(state.station);
    }
    return heard.size() == 2;
  }));
  EXPECT_THAT(heard, testing::UnorderedElementsAre("left", "right"));
}

TEST(Reader, WaitsForItsCallbackWhenDestroyed) {
  const Participant participant = Participant::Loop(kDomain, kUdp);
  const std::string topic = OwnTopic("wait");
  std::atomic<bool> begun{false};
  std::atomic<bool> ended{false};
  Writer<wire::HapticPose> writer(participant, topic, Qos::kLoop);
  {
    const Reader<wire::HapticPose> reader(participant, topic, Qos::kLoop,
                                          [&](const wire::HapticPose&) {
                                            begun = true;
                                            std::this_thread::sleep_for(milliseconds(100));
                                            ended = true;
                                          });
    ASSERT_TRUE(test::Eventually([&] { return writer.matched_readers() == 1; }));
    // In another thread, because a writer itself delivers to the readers of its process.
    std::thread write([&] { writer.Write(wire::HapticPose{}); });
    ASSERT_TRUE(test::Eventually([&] { return begun.load(); }));
    write.detach();
  }
  EXPECT_TRUE(ended);
  std::this_thread::sleep_for(milliseconds(50));
}

template <class T>
void ExpectCdrIsTheStruct(T sample) {
  // Every byte differs from its neighbours, so that a swap or a gap shows.  Any bits will do.
  auto* bytes = reinterpret_cast<unsigned char*>(&sample);
  for (std::size_t i = 0; i < sizeof sample; ++i) bytes[i] = static_cast<unsigned char>(i * 37 + 1);
  const Participant participant = Participant::Loop(kDomain, kUdp);
  const std::string topic = OwnTopic("cdr");
  Writer<T> writer(participant, topic, Qos::kLoop);
  const Reader<T> reader(participant, topic, Qos::kLoop);
  ASSERT_TRUE(test::Eventually([&] { return writer.matched_readers() == 1; }));
  ASSERT_TRUE(writer.Write(sample));
  ddsi_serdata* data[1] = {nullptr};
  dds_sample_info_t info;
  ASSERT_TRUE(test::Eventually(
      [&] { return dds_takecdr(reader.handle(), data, 1, &info, DDS_ANY_STATE) == 1; }));
  std::vector<unsigned char> cdr(ddsi_serdata_size(data[0]));
  ASSERT_EQ(cdr.size(), 4 + sizeof sample);
  ddsi_serdata_to_ser(data[0], 0, cdr.size(), cdr.data());
  ddsi_serdata_unref(data[0]);
  EXPECT_THAT(std::vector(cdr.begin(), cdr.begin() + 4), testing::ElementsAre(0, 1, 0, 0));
  EXPECT_EQ(std::memcmp(cdr.data() + 4, &sample, sizeof sample), 0);
}

TEST(Wire, LoopSamplesInCdrAreTheirCStructs) {
  ExpectCdrIsTheStruct(wire::HapticPose{});
  ExpectCdrIsTheStruct(wire::Wrench{});
}

TEST(Wire, ConvertsPosesThereAndBack) {
  const Pose X{Vec3(1, 2, 3), Quat(0.5, -0.5, 0.5, -0.5)};
  wire::HapticPose sample{};
  wire::FromPose(X, sample.position_m, sample.orientation_wxyz);
  EXPECT_THAT(sample.orientation_wxyz, testing::ElementsAre(0.5, -0.5, 0.5, -0.5));
  EXPECT_EQ(wire::ToPose(sample).p, X.p);
  EXPECT_EQ(wire::ToPose(sample).q.coeffs(), X.q.coeffs());
}

TEST(Wire, CutsTextToItsField) {
  char field[5];
  wire::FromText("longer than that", field);
  EXPECT_STREQ(field, "long");
  wire::FromText("", field);
  EXPECT_THAT(field, testing::Each('\0'));
}

}  // namespace
}  // namespace palpate::dds
