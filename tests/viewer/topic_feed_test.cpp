#include "client/viewer/topic_feed.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/dds/cdr.h"
#include "common/dds/topics.h"
#include "common/files/bundle_hash.h"
#include "tests/support/eventually.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using testing::ElementsAre;

const int kDomain = test::OwnDomain();

/// A server's service side while the object lives.
struct Server {
  void WriteBundle(const std::string& scene, std::uint64_t run, std::vector<std::uint8_t> bytes,
                   std::uint64_t forged = 0) {
    wire::SceneBundle sample{};
    wire::FromText(scene, sample.scene);
    sample.server_run = run;
    sample.hash = BundleHash(bytes) + forged;
    sample.bundle._buffer = bytes.data();
    sample.bundle._length = sample.bundle._maximum = static_cast<std::uint32_t>(bytes.size());
    ASSERT_TRUE(bundles.Write(sample));
  }
  void WriteSession(const std::string& station, std::uint64_t run, wire::SessionPhase phase) {
    wire::SessionState sample{};
    wire::FromText(station, sample.station);
    sample.server_run = run;
    sample.phase = phase;
    ASSERT_TRUE(states.Write(sample));
  }
  /// A block of object 1 in scene s.
  void WriteBlock(std::uint32_t block, std::uint64_t change) {
    wire::SolidBlock sample{};
    wire::FromText("s", sample.scene);
    sample.object_index = 1;
    sample.block = block;
    sample.change = change;
    sample.server_run = 1;
    ASSERT_TRUE(blocks.Write(sample));
  }
  void WriteTool(const std::string& station) {
    wire::ToolState sample{};
    wire::FromText(station, sample.station);
    tools.Write(sample);
  }
  void WriteReplay(double at_s) {
    wire::ReplayState sample{};
    sample.replay = 0xab;
    sample.at_s = at_s;
    ASSERT_TRUE(replays.Write(sample));
  }

  dds::Participant participant = dds::Participant::Service(kDomain);
  dds::Writer<wire::SceneBundle> bundles{participant, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::Writer<wire::SessionState> states{participant, dds::kSessionStateTopic, dds::Qos::kSession};
  dds::Writer<wire::SolidBlock> blocks{participant, dds::kSolidBlockTopic, dds::Qos::kSession};
  dds::Writer<wire::SceneWhole> wholes{participant, dds::kSceneWholeTopic, dds::Qos::kSession};
  dds::Writer<wire::ToolState> tools{participant, dds::kToolStateTopic, dds::Qos::kStream};
  dds::Writer<wire::ReplayState> replays{participant, dds::kReplayStateTopic, dds::Qos::kSession};
};

/// Another server, with a session and a scene of this content.
std::unique_ptr<Server> Another(std::uint64_t run, std::uint8_t content) {
  auto server = std::make_unique<Server>();
  server->WriteSession("forged", run, palpate_SESSION_ACTIVE);
  server->WriteBundle("s", run, {content});
  return server;
}

/// A server and a feed, in one process.
class TopicFeedTest : public testing::Test {
 protected:
  template <class Condition>
  bool PollUntil(Condition condition, double seconds = 30.0) {
    return test::Eventually(
        [&] {
          feed_.Poll(
              [this](const FramePtr& frame) { frames_.push_back(frame); },
              [this](const wire::SessionState& state) { sessions_.push_back(state.station); });
          return condition();
        },
        seconds);
  }
  bool PollUntilKept(TopicFeed::Channel channel, std::size_t count) {
    return PollUntil([&] { return feed_.Kept(channel).size() == count; });
  }
  bool PollUntilHas(std::size_t scenes, std::size_t stations) {
    return PollUntil(
        [&] { return feed_.scenes().size() == scenes && feed_.stations().size() == stations; });
  }
  void PollFor(double seconds) {
    PollUntil([] { return false; }, seconds);
  }

  Server server_;
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
    server_.WriteBundle(name, 1, bytes);
    ASSERT_TRUE(PollUntil([&] { return feed_.scenes().contains(name); }));
    const SceneBytes& scene = feed_.scenes().at(name);
    EXPECT_EQ(scene.hash, BundleHash(bytes));
    EXPECT_EQ(std::vector(scene.bundle.begin(), scene.bundle.end()), bytes);
  }
}

TEST_F(TopicFeedTest, KeepsWhatHasAStateInItsOrderAndNothingElse) {
  for (std::uint32_t i = 1; i <= 300; ++i) server_.WriteBlock(i, i);
  server_.WriteSession("a", 1, palpate_SESSION_WAITING);
  server_.WriteSession("a", 1, palpate_SESSION_ACTIVE);
  server_.WriteSession("b", 1, palpate_SESSION_REFUSED);
  server_.WriteSession("c", 1, palpate_SESSION_HELD);
  server_.WriteSession("d", 1, palpate_SESSION_ENDED);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSessionState, 4));
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 300));
  EXPECT_TRUE(feed_.server().lives);
  EXPECT_THAT(feed_.stations(), ElementsAre("a"));
  for (const char* there : {"a", "c"}) EXPECT_TRUE(feed_.HasStation(there)) << there;
  for (const char* gone : {"b", "d", "e"}) EXPECT_FALSE(feed_.HasStation(gone)) << gone;
  const auto blocks = feed_.Kept(TopicFeed::kSolidBlock);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    wire::SolidBlock block{};
    ASSERT_TRUE(dds::FromCdr(blocks[i]->payload, block));
    EXPECT_EQ(block.change, i + 1);
    EXPECT_TRUE(blocks[i]->state);
  }
  frames_.clear();
  ASSERT_TRUE(PollUntil([&] {
    server_.WriteTool("a");
    return !frames_.empty();
  }));
  EXPECT_EQ(frames_[0]->channel, TopicFeed::kToolState);
  EXPECT_FALSE(frames_[0]->state);
  EXPECT_TRUE(feed_.Kept(TopicFeed::kToolState).empty());
}

TEST_F(TopicFeedTest, KnowsWhatAServerCompilesAsLongAsItDoes) {
  EXPECT_EQ(feed_.compiling(), nullptr);
  {
    dds::Writer<wire::SceneProgress> writer{server_.participant, dds::kSceneProgressTopic,
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

TEST_F(TopicFeedTest, KeepsOfEachBlockOfASolidTheNewestUntilItIsUndone) {
  for (std::uint64_t change = 1; change <= 5; ++change) server_.WriteBlock(3, change);
  server_.WriteBlock(4, 6);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 2));
  const auto kept = [&](std::size_t i) {
    wire::SolidBlock block{};
    EXPECT_TRUE(dds::FromCdr(feed_.Kept(TopicFeed::kSolidBlock)[i]->payload, block));
    return block;
  };
  EXPECT_TRUE(PollUntil([&] { return kept(0).change == 5; }));
  EXPECT_TRUE(feed_.Kept(TopicFeed::kSolidBlock)[0]->state);
  wire::SceneWhole whole{};
  wire::FromText("s", whole.scene);
  whole.server_run = 1;
  whole.last_change = 5;
  server_.wholes.Write(whole);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 1));
  EXPECT_EQ(kept(0).block, 4u);
  server_.WriteBlock(9, 5);  // delayed
  server_.WriteBlock(3, 7);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 2));
  EXPECT_EQ(kept(0).change, 7u);
  server_.WriteBundle("s", 2, {3});
  EXPECT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 0));
}

TEST_F(TopicFeedTest, LetsANewServerTakeThePlaceOfTheFormerWhoseRestIsNotHeard) {
  server_.WriteBundle("s", 1, {1});
  server_.WriteBundle("gone", 1, {2});
  server_.WriteBlock(1, 1);
  server_.WriteSession("a", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntilHas(2, 1));
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSolidBlock, 1));
  server_.WriteBundle("s", 2, {3});
  ASSERT_TRUE(PollUntil([&] { return feed_.scenes().size() == 1; }));
  EXPECT_EQ(feed_.scenes().at("s").bundle[0], 3);
  EXPECT_TRUE(feed_.Kept(TopicFeed::kSolidBlock).empty());
  EXPECT_TRUE(feed_.stations().empty());
  const std::size_t heard = sessions_.size();
  server_.WriteSession("late", 1, palpate_SESSION_ACTIVE);
  server_.WriteSession("b", 2, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntil([&] { return sessions_.size() > heard; }));
  EXPECT_THAT(feed_.stations(), ElementsAre("b"));
}

TEST_F(TopicFeedTest, HearsTheServerThatLivesWhateverAnotherSays) {
  server_.WriteBundle("s", 1, {1});
  server_.WriteSession("a", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntilHas(1, 1));
  for (const std::uint64_t run : {1, 2}) {  // under the server's own run, too
    const auto stranger = Another(run, 7);
    // All its messages have been ignored once later ones of the first server have come.
    const std::string name = "after" + std::to_string(run);
    ASSERT_TRUE(PollUntil([&] {
      stranger->WriteTool("forged");
      server_.WriteSession(name, 1, palpate_SESSION_ACTIVE);
      return feed_.Kept(TopicFeed::kSessionState).size() == 1 + run;
    }));
    PollFor(0.2);
    EXPECT_EQ(feed_.server().run, 1u);
    EXPECT_EQ(feed_.scenes().at("s").bundle[0], 1);
  }
  EXPECT_THAT(feed_.stations(), ElementsAre("a", "after1", "after2"));
  server_.WriteSession("b", 1, palpate_SESSION_ACTIVE);
  EXPECT_TRUE(PollUntil([&] { return feed_.stations().size() == 4; })) << "it is blind since then";
  for (const FramePtr& frame : frames_) {
    EXPECT_NE(frame->channel, static_cast<std::uint32_t>(TopicFeed::kToolState));
  }
}

TEST_F(TopicFeedTest, HearsAllThatAnotherHasSaidOnceTheFirstHasGone) {
  auto first = Another(1, 7);
  ASSERT_TRUE(PollUntil([&] { return feed_.server().run == 1; }));
  server_.WriteBundle("s", 2, {1});
  server_.WriteBundle("t", 2, {2});
  server_.WriteSession("a", 2, palpate_SESSION_ACTIVE);
  PollFor(0.3);
  ASSERT_EQ(feed_.server().run, 1u);
  first.reset();
  EXPECT_TRUE(PollUntilHas(2, 1));
  EXPECT_EQ(feed_.server().run, 2u);
  EXPECT_THAT(feed_.stations(), ElementsAre("a"));
}

TEST_F(TopicFeedTest, KeepsWhatAServerHasSaidWhileThereIsNone) {
  Another(1, 7);
  auto server = Another(2, 8);
  ASSERT_TRUE(PollUntil([&] { return feed_.server().run == 2; }));
  server.reset();
  PollFor(0.4);
  EXPECT_EQ(feed_.server().run, 2u);
  EXPECT_EQ(feed_.scenes().at("s").bundle[0], 8);
}

TEST_F(TopicFeedTest, ForgetsASessionThatIsOverForTheServerThatSaysSo) {
  server_.WriteSession("a", 1, palpate_SESSION_REFUSED);
  server_.WriteSession("b", 1, palpate_SESSION_ACTIVE);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kSessionState, 2));
  wire::SessionState over{};
  wire::FromText("a", over.station);
  server_.states.Dispose(over);
  EXPECT_TRUE(PollUntilKept(TopicFeed::kSessionState, 1));
  EXPECT_THAT(feed_.stations(), ElementsAre("b"));
}

TEST_F(TopicFeedTest, ShowsNoBundleThatIsNotWhatItsHashSays) {
  server_.WriteBundle("forged", 1, {1, 2, 3}, 1);
  server_.WriteBundle("true", 1, {1, 2, 3});
  ASSERT_TRUE(PollUntil([&] { return feed_.scenes().contains("true"); }));
  EXPECT_EQ(feed_.scenes().size(), 1u);
}

TEST_F(TopicFeedTest, KeepsWhatAReplaySaysWhoeverElseSpeaks) {
  dds::Writer<wire::ReplayContents> contents(server_.participant, dds::kReplayContentsTopic,
                                             dds::Qos::kSession);
  wire::ReplayContents of{};
  of.replay = 0xab;
  wire::FromText("lesson.mcap", of.recording);
  ASSERT_TRUE(contents.Write(of));
  server_.WriteReplay(2.5);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kReplayState, 1));
  // After seeking it speaks as another server; it is the same replay.
  server_.WriteBundle("s", 1, {1});
  server_.WriteBundle("s", 2, {2});
  ASSERT_TRUE(PollUntil([&] { return feed_.server().run == 2; }));
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
  EXPECT_THAT(feed_.Ask(request), testing::HasSubstr("has ended"));
  dds::Reader<wire::ReplayRequest> requests(server_.participant, dds::kReplayRequestTopic,
                                            dds::Qos::kRecordSession);
  server_.WriteReplay(0);
  ASSERT_TRUE(PollUntilKept(TopicFeed::kReplayState, 1));
  request.request = 5;
  request.wish = palpate_REPLAY_SEEK;
  request.value = 1.5;
  EXPECT_EQ(feed_.Ask(request), "");
  wire::ReplayRequest heard{};
  ASSERT_TRUE(PollUntil([&] { return requests.Take(heard); }));
  EXPECT_EQ(heard.request, 5u);
  EXPECT_EQ(heard.value, 1.5);
}

TEST(TopicFeed, OffersAMouseAndAReplaysAnswerToThoseWhoMay) {
  const std::size_t plain = ChannelsFor(false, false).size();
  EXPECT_EQ(ChannelsFor(false, true).size(), plain + 1);
  EXPECT_EQ(ChannelsFor(true, true).size(), plain + 2);
}

}  // namespace
}  // namespace palpate
