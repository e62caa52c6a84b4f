#include "client/viewer/topic_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>
#include <xxhash.h>

#include "common/dds/cdr.h"
#include "common/dds/topics.h"
#include "tests/support/eventually.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using testing::ElementsAre;

const int kDomain = test::OwnDomain();

/// A server's service side and a feed, in one process.
class TopicFeedTest : public testing::Test {
 protected:
  template <class Condition>
  bool PollUntil(Condition condition) {
    return test::Eventually([&] {
      feed_.Poll([this](const FramePtr& frame) { frames_.push_back(frame); },
                 [this](const wire::SessionState& state) { sessions_.push_back(state.station); });
      return condition();
    });
  }
  void WriteBundle(const std::string& scene, std::uint64_t run, std::vector<std::uint8_t> bytes) {
    wire::SceneBundle sample{};
    wire::FromText(scene, sample.scene);
    sample.server_run = run;
    sample.hash = XXH3_64bits(bytes.data(), bytes.size());
    sample.bundle._buffer = bytes.data();
    sample.bundle._length = sample.bundle._maximum = static_cast<std::uint32_t>(bytes.size());
    ASSERT_TRUE(bundles_.Write(sample));
  }
  void WriteSession(const std::string& station, std::uint64_t run, wire::SessionPhase phase) {
    wire::SessionState sample{};
    wire::FromText(station, sample.station);
    sample.server_run = run;
    sample.phase = phase;
    ASSERT_TRUE(states_.Write(sample));
  }
  void WriteChange(std::uint64_t number, std::uint64_t run) {
    wire::SceneChange sample{};
    wire::FromText("s", sample.scene);
    sample.change = number;
    sample.server_run = run;
    ASSERT_TRUE(changes_.Write(sample));
  }

  dds::Participant participant_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::SceneBundle> bundles_{participant_, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::Writer<wire::SessionState> states_{participant_, dds::kSessionStateTopic,
                                          dds::Qos::kSession};
  dds::Writer<wire::SceneChange> changes_{participant_, dds::kSceneChangeTopic, dds::Qos::kSession};
  dds::Writer<wire::SceneWhole> wholes_{participant_, dds::kSceneWholeTopic, dds::Qos::kSession};
  dds::Writer<wire::ToolState> tools_{participant_, dds::kToolStateTopic, dds::Qos::kStream};
  TopicFeed feed_{kDomain};
  std::vector<FramePtr> frames_;
  std::vector<std::string> sessions_;
};

TEST_F(TopicFeedTest, FindsTheBundleInTheBytesThatTravelled) {
  for (std::size_t size = 1; size < 9; ++size) {
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < size) {
      bytes.push_back(static_cast<std::uint8_t>(17 * bytes.size() + size));
    }
    const std::string name = "scene" + std::string(size, 'x');
    WriteBundle(name, 1, bytes);
    ASSERT_TRUE(PollUntil([&] { return feed_.scenes().contains(name); }));
    const SceneBytes& scene = feed_.scenes().at(name);
    EXPECT_EQ(scene.hash, XXH3_64bits(bytes.data(), bytes.size()));
    EXPECT_EQ(std::vector(scene.bundle.begin(), scene.bundle.end()), bytes);
  }
}

TEST_F(TopicFeedTest, KeepsWhatHasAStateInItsOrderAndNothingElse) {
  for (std::uint64_t number = 1; number <= 300; ++number) WriteChange(number, 1);
  WriteSession("a", 1, palpate_SESSION_WAITING);
  WriteSession("a", 1, palpate_SESSION_ACTIVE);
  WriteSession("b", 1, palpate_SESSION_REFUSED);
  ASSERT_TRUE(PollUntil([&] {
    return feed_.Kept(TopicFeed::kSceneChange).size() == 300 &&
           feed_.Kept(TopicFeed::kSessionState).size() == 2;
  }));
  EXPECT_THAT(feed_.stations(), ElementsAre("a"));
  const auto changes = feed_.Kept(TopicFeed::kSceneChange);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    wire::SceneChange change{};
    ASSERT_TRUE(dds::FromCdr(changes[i]->payload, change));
    EXPECT_EQ(change.change, i + 1);
    EXPECT_TRUE(changes[i]->state);
  }
  frames_.clear();
  ASSERT_TRUE(PollUntil([&] {
    wire::ToolState tool{};
    wire::FromText("a", tool.station);
    tools_.Write(tool);
    return !frames_.empty();
  }));
  EXPECT_EQ(frames_[0]->channel, TopicFeed::kToolState);
  EXPECT_FALSE(frames_[0]->state);
  EXPECT_TRUE(feed_.Kept(TopicFeed::kToolState).empty());
}

TEST_F(TopicFeedTest, KnowsWhatAServerCompilesAsLongAsItDoes) {
  EXPECT_EQ(feed_.compiling(), nullptr);
  {
    dds::Writer<wire::SceneProgress> writer{participant_, dds::kSceneProgressTopic,
                                            dds::Qos::kSession};
    wire::SceneProgress progress{};
    wire::FromText("cube", progress.scene);
    wire::FromText("touching balls", progress.stage);
    progress.done = 0.43;
    ASSERT_TRUE(writer.Write(progress));
    ASSERT_TRUE(PollUntil([&] { return feed_.compiling() != nullptr; }));
    EXPECT_STREQ(feed_.compiling()->stage, "touching balls");
    EXPECT_EQ(feed_.compiling()->done, 0.43);
  }
  EXPECT_TRUE(PollUntil([&] { return feed_.compiling() == nullptr; }));
}

TEST_F(TopicFeedTest, KnowsWhichStationsThereAreAlsoThoseThatWait) {
  WriteSession("a", 1, palpate_SESSION_ACTIVE);
  WriteSession("b", 1, palpate_SESSION_HELD);
  WriteSession("c", 1, palpate_SESSION_ENDED);
  ASSERT_TRUE(PollUntil([&] { return sessions_.size() == 3; }));
  EXPECT_TRUE(feed_.server_lives());
  EXPECT_TRUE(feed_.HasStation("a"));
  EXPECT_TRUE(feed_.HasStation("b"));
  EXPECT_FALSE(feed_.HasStation("c"));
  EXPECT_FALSE(feed_.HasStation("d"));
}

TEST_F(TopicFeedTest, ForgetsChangesThatAreUndoneWhicheverIsHeardFirst) {
  for (std::uint64_t number = 1; number <= 5; ++number) WriteChange(number, 1);
  ASSERT_TRUE(PollUntil([&] { return feed_.Kept(TopicFeed::kSceneChange).size() == 5; }));
  wire::SceneChange change{};
  ASSERT_TRUE(dds::FromCdr(feed_.Kept(TopicFeed::kSceneChange)[0]->payload, change));
  wire::SceneWhole whole{};
  wire::FromText(change.scene, whole.scene);
  whole.server_run = 1;
  whole.last_change = 7;
  wholes_.Write(whole);
  ASSERT_TRUE(PollUntil([&] { return !feed_.Kept(TopicFeed::kSceneWhole).empty(); }));
  EXPECT_TRUE(feed_.Kept(TopicFeed::kSceneChange).empty());
  for (std::uint64_t number = 6; number <= 9; ++number) WriteChange(number, 1);
  ASSERT_TRUE(PollUntil([&] { return feed_.Kept(TopicFeed::kSceneChange).size() == 2; }));
  ASSERT_TRUE(dds::FromCdr(feed_.Kept(TopicFeed::kSceneChange)[0]->payload, change));
  EXPECT_EQ(change.change, 8u);
}

TEST_F(TopicFeedTest, LetsANewServerTakeThePlaceOfTheFormerWhoseRestIsNotHeard) {
  WriteBundle("s", 1, {1});
  WriteBundle("gone", 1, {2});
  WriteChange(1, 1);
  WriteSession("a", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntil([&] {
    return feed_.scenes().size() == 2 && feed_.stations().size() == 1 &&
           feed_.Kept(TopicFeed::kSceneChange).size() == 1;
  }));
  WriteBundle("s", 2, {3});
  ASSERT_TRUE(PollUntil([&] { return feed_.scenes().size() == 1; }));
  EXPECT_EQ(feed_.scenes().at("s").bundle[0], 3);
  EXPECT_TRUE(feed_.Kept(TopicFeed::kSceneChange).empty());
  EXPECT_TRUE(feed_.stations().empty());
  const std::size_t heard = sessions_.size();
  WriteSession("late", 1, palpate_SESSION_ACTIVE);
  WriteSession("b", 2, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntil([&] { return sessions_.size() > heard; }));
  EXPECT_THAT(feed_.stations(), ElementsAre("b"));
}

/// Another participant that speaks as a server, for as long as it lives.
struct Stranger {
  explicit Stranger(const std::string& scene, std::uint64_t run, std::uint8_t content) {
    wire::SessionState state{};
    wire::FromText("forged", state.station);
    state.server_run = run;
    state.phase = palpate_SESSION_ACTIVE;
    EXPECT_TRUE(states.Write(state));
    wire::SceneBundle bundle{};
    wire::FromText(scene, bundle.scene);
    bundle.server_run = run;
    bundle.hash = XXH3_64bits(&content, 1);
    bundle.bundle._buffer = &content;
    bundle.bundle._length = bundle.bundle._maximum = 1;
    EXPECT_TRUE(bundles.Write(bundle));
  }
  dds::Participant participant = dds::Participant::Service(kDomain);
  dds::Writer<wire::SceneBundle> bundles{participant, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::Writer<wire::SessionState> states{participant, dds::kSessionStateTopic, dds::Qos::kSession};
  dds::Writer<wire::ToolState> tools{participant, dds::kToolStateTopic, dds::Qos::kStream};
};

TEST_F(TopicFeedTest, HearsTheServerThatLivesWhateverAnotherSays) {
  WriteBundle("s", 1, {1});
  WriteSession("a", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(
      PollUntil([&] { return feed_.scenes().size() == 1 && feed_.stations().size() == 1; }));
  for (const std::uint64_t run : {1, 2}) {  // under the server's own run, too
    const Stranger stranger("s", run, 7);
    // Each of its words has been passed over once later ones of the server's own have come.
    const std::string name = "after" + std::to_string(run);
    ASSERT_TRUE(PollUntil([&] {
      wire::ToolState state{};
      wire::FromText("forged", state.station);
      const_cast<Stranger&>(stranger).tools.Write(state);
      WriteSession(name, 1, palpate_SESSION_ACTIVE);
      return feed_.Kept(TopicFeed::kSessionState).size() == 1 + run;
    }));
    usleep(200'000);
    PollUntil([] { return true; });
    EXPECT_EQ(feed_.server_run(), 1u);
    EXPECT_EQ(feed_.scenes().at("s").bundle[0], 1);
  }
  EXPECT_THAT(feed_.stations(), ElementsAre("a", "after1", "after2"));
  WriteSession("b", 1, palpate_SESSION_ACTIVE);
  EXPECT_TRUE(PollUntil([&] { return feed_.stations().size() == 4; })) << "it is blind since then";
  for (const FramePtr& frame : frames_) {
    EXPECT_NE(frame->channel, static_cast<std::uint32_t>(TopicFeed::kToolState));
  }
}

TEST_F(TopicFeedTest, HearsAllThatAnotherHasSaidOnceTheFirstHasGone) {
  auto first = std::make_unique<Stranger>("s", 1, 7);
  ASSERT_TRUE(PollUntil([&] { return feed_.server_run() == 1; }));
  WriteBundle("s", 2, {1});
  WriteBundle("t", 2, {2});
  WriteSession("a", 2, palpate_SESSION_ACTIVE);
  for (int i = 0; i < 200; ++i) {
    PollUntil([] { return true; });
    usleep(1000);
  }
  ASSERT_EQ(feed_.server_run(), 1u);
  first.reset();
  EXPECT_TRUE(
      PollUntil([&] { return feed_.scenes().size() == 2 && feed_.stations().size() == 1; }));
  EXPECT_EQ(feed_.server_run(), 2u);
  EXPECT_THAT(feed_.stations(), ElementsAre("a"));
}

TEST_F(TopicFeedTest, KeepsWhatAServerHasSaidWhileThereIsNone) {
  std::make_unique<Stranger>("s", 1, 7);
  auto server = std::make_unique<Stranger>("s", 2, 8);
  ASSERT_TRUE(PollUntil([&] { return feed_.server_run() == 2; }));
  server.reset();
  for (int i = 0; i < 300; ++i) {
    PollUntil([] { return true; });
    usleep(1000);
  }
  EXPECT_EQ(feed_.server_run(), 2u);
  EXPECT_EQ(feed_.scenes().at("s").bundle[0], 8);
}

TEST_F(TopicFeedTest, ForgetsASessionThatIsOverForTheServerThatSaysSo) {
  WriteSession("a", 1, palpate_SESSION_REFUSED);
  WriteSession("b", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntil([&] { return feed_.Kept(TopicFeed::kSessionState).size() == 2; }));
  wire::SessionState over{};
  wire::FromText("a", over.station);
  states_.Dispose(over);
  EXPECT_TRUE(PollUntil([&] { return feed_.Kept(TopicFeed::kSessionState).size() == 1; }));
  EXPECT_THAT(feed_.stations(), ElementsAre("b"));
}

TEST_F(TopicFeedTest, ShowsNoBundleThatIsNotWhatItsHashSays) {
  std::vector<std::uint8_t> bytes = {1, 2, 3};
  wire::SceneBundle forged{};
  wire::FromText("forged", forged.scene);
  forged.server_run = 1;
  forged.hash = XXH3_64bits(bytes.data(), bytes.size()) + 1;
  forged.bundle._buffer = bytes.data();
  forged.bundle._length = forged.bundle._maximum = 3;
  ASSERT_TRUE(bundles_.Write(forged));
  WriteBundle("true", 1, bytes);
  ASSERT_TRUE(PollUntil([&] { return feed_.scenes().contains("true"); }));
  EXPECT_EQ(feed_.scenes().size(), 1u);
}

TEST_F(TopicFeedTest, KeepsWhatAReplaySaysWhoeverElseSpeaks) {
  dds::Writer<wire::ReplayContents> contents(participant_, dds::kReplayContentsTopic,
                                             dds::Qos::kSession);
  dds::Writer<wire::ReplayState> states(participant_, dds::kReplayStateTopic, dds::Qos::kSession);
  wire::ReplayContents of{};
  of.replay = 0xab;
  wire::FromText("lesson.mcap", of.recording);
  ASSERT_TRUE(contents.Write(of));
  wire::ReplayState state{};
  state.replay = 0xab;
  state.at_s = 2.5;
  ASSERT_TRUE(states.Write(state));
  ASSERT_TRUE(PollUntil([&] { return !feed_.Kept(TopicFeed::kReplayState).empty(); }));
  // Where it goes elsewhere it speaks as another server; it is the same replay.
  WriteBundle("s", 1, {1});
  WriteBundle("s", 2, {2});
  ASSERT_TRUE(PollUntil([&] { return feed_.server_run() == 2; }));
  const auto kept = feed_.Kept(TopicFeed::kReplayContents);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(kept[0]->state);
  EXPECT_EQ(kept[0]->channel, static_cast<std::uint32_t>(TopicFeed::kReplayContents));
  const auto json = nlohmann::json::parse(kept[0]->payload);
  EXPECT_EQ(json["replay"], "ab");
  EXPECT_EQ(json["recording"], "lesson.mcap");
  EXPECT_EQ(nlohmann::json::parse(feed_.Kept(TopicFeed::kReplayState).at(0)->payload)["at_s"], 2.5);
}

TEST_F(TopicFeedTest, PassesWishesOnToAReplayThatIsThere) {
  wire::ReplayRequest request{};
  request.replay = 0xab;
  EXPECT_THAT(feed_.Ask(request), testing::HasSubstr("not there any more"));
  dds::Writer<wire::ReplayState> states(participant_, dds::kReplayStateTopic, dds::Qos::kSession);
  dds::Reader<wire::ReplayRequest> requests(participant_, dds::kReplayRequestTopic,
                                            dds::Qos::kRecordSession);
  wire::ReplayState state{};
  state.replay = 0xab;
  ASSERT_TRUE(states.Write(state));
  ASSERT_TRUE(PollUntil([&] { return !feed_.Kept(TopicFeed::kReplayState).empty(); }));
  request.request = 5;
  request.wish = palpate_REPLAY_SEEK;
  request.value = 1.5;
  EXPECT_EQ(feed_.Ask(request), "");
  wire::ReplayRequest heard{};
  ASSERT_TRUE(PollUntil([&] { return requests.Take(heard); }));
  EXPECT_EQ(heard.request, 5u);
  EXPECT_EQ(heard.value, 1.5);
}

TEST_F(TopicFeedTest, OffersEachTopicWithASchemaThatDeclaresItsType) {
  EXPECT_EQ(TopicFeed::Channels(true, true).size(), 12u);
  EXPECT_EQ(TopicFeed::Channels(false, true).size(), 11u);
  const auto channels = TopicFeed::Channels(false, false);
  EXPECT_EQ(channels.size(), 10u);
  for (const foxglove::Channel& channel : channels) {
    if (channel.encoding != "cdr") continue;
    EXPECT_THAT(channel.schema,
                testing::HasSubstr("struct " + channel.schema_name.substr(9) + " {"));
  }
}

}  // namespace
}  // namespace palpate
