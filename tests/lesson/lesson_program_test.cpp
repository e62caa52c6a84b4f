// A cut scene is made whole, with everything involved: server, hand, recorder, command and replay.
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "tests/support/eventually.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

const int kDomain = OwnDomain();

Program Here(const std::string& program, std::vector<std::string> words) {
  words.insert(words.end(), {"--domain", std::to_string(kDomain)});
  return {PALPATE_BIN_DIR "/" + program, std::move(words)};
}

TEST(LessonProgram, SaysWhatThereIsToDoWhereNothingIsAskedFor) {
  Program program(PALPATE_BIN_DIR "/palpate-lesson", {});
  EXPECT_EQ(program.Exit(), 2);
  EXPECT_THAT(program.Output(), HasSubstr("palpate-lesson whole SCENE"));
}

TEST(LessonProgram, SaysThatNoServerIsThere) {
  Program program = Here("palpate-lesson", {"whole", "calculus"});
  EXPECT_EQ(program.Exit(), 1);
  EXPECT_THAT(program.Output(), HasSubstr("no server found in domain"));
}

TEST(LessonProgram, MakesWholeWhatAHandScrapesOffAndTheRecordingOfItIsVerified) {
  const std::string file =
      testing::TempDir() + "palpate_lesson_" + std::to_string(getpid()) + ".mcap";
  Program server =
      Here("palpate-server", {"calculus", "cube", "--transport", "udp", "--realtime", "off"});
  ASSERT_TRUE(server.Says("ready: ", 60.0)) << server.Output();
  Program recorder = Here("palpate-record", {"-o", file, "--overwrite", "--transport", "udp"});
  ASSERT_TRUE(recorder.Says("recording to ")) << recorder.Output();
  Program station =
      Here("palpate-station", {"--device", "simulated", "--scene", "calculus", "--id", "hand",
                               "--loop", "--no-table", "--transport", "udp", "--realtime", "off"});
  const dds::Participant viewer = dds::Participant::Service(kDomain);
  dds::Reader<wire::SolidBlock> blocks(viewer, dds::kSolidBlockTopic, dds::Qos::kRecordSession);
  dds::Reader<wire::SceneWhole> wholes(viewer, dds::kSceneWholeTopic, dds::Qos::kSession);
  wire::SolidBlock block{};
  const auto scraped_past = [&](std::uint64_t number) {
    return Eventually(
        [&] {
          server.Output();  // so that no full pipe stops it
          while (blocks.Take(block)) continue;
          return block.change > number;
        },
        60.0);
  };
  ASSERT_TRUE(scraped_past(5)) << station.Output() << server.Output();

  Program lesson = Here("palpate-lesson", {"whole", "calculus"});
  EXPECT_EQ(lesson.Exit(), 0);
  EXPECT_THAT(lesson.Output(), HasSubstr("calculus: whole again"));
  wire::SceneWhole whole{};
  ASSERT_TRUE(Eventually([&] { return wholes.Take(whole); }, 60.0));
  EXPECT_GE(whole.last_change, 5u);
  EXPECT_STREQ(whole.by, "palpate-lesson");
  // The hand goes on scraping.
  EXPECT_TRUE(scraped_past(whole.last_change + 3)) << station.Output();

  for (const auto& [scene, why] : {std::pair{"cube", "nothing goes there"},
                                   std::pair{"mould", "give one of calculus, cube"}}) {
    Program refused = Here("palpate-lesson", {"whole", scene});
    EXPECT_EQ(refused.Exit(), 1);
    EXPECT_THAT(refused.Output(), HasSubstr(why));
  }
  station.Signal(SIGINT);
  EXPECT_EQ(station.Exit(), 0);
  Program trial =
      Here("palpate-station", {"--device", "simulated", "--scene", "calculus", "--id", "trial",
                               "--keep-scene", "--transport", "udp", "--realtime", "off"});
  ASSERT_TRUE(trial.Says("active")) << trial.Output();
  for (const char* const wish : {"whole", "bookmark", "back"}) {
    Program refused = Here("palpate-lesson", {wish, "calculus"});
    EXPECT_EQ(refused.Exit(), 1);
    EXPECT_THAT(refused.Output(), HasSubstr("station 'trial' is in a trial there"));
  }
  trial.Signal(SIGINT);
  EXPECT_EQ(trial.Exit(), 0);
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.Exit(), 0) << recorder.Output();
  server.Signal(SIGINT);
  EXPECT_EQ(server.Exit(), 0);

  Program verify(PALPATE_BIN_DIR "/palpate-replay", {file, "--verify"});
  EXPECT_EQ(verify.Exit(60.0), 0) << verify.Output();
  EXPECT_THAT(verify.Output(), HasSubstr("same: station hand"));
  Program info(PALPATE_BIN_DIR "/palpate-record", {"info", file});
  EXPECT_EQ(info.Exit(), 0);
  EXPECT_THAT(info.Output(), HasSubstr("palpate/scene_whole"));
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace palpate::test
