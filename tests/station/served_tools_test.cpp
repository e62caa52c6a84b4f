#include "client/station/served_tools.h"

#include <limits>

#include <gmock/gmock.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "tests/support/complaint.h"
#include "tests/support/test_domain.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

const int kToolsDomain = test::OwnDomain();

template <class T, class Sequence>
void PointTo(std::vector<T>& items, Sequence& sequence) {
  sequence._buffer = items.data();
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(items.size());
}

wire::HandKey Key(double t, double y) {
  wire::HandKey key{};
  key.time_s = t;
  key.position_m[1] = y;
  key.orientation_wxyz[0] = 1.0;
  wire::FromText("press", key.label);
  return key;
}

/// Offers scene 'mine' from own.json with the tools 'left', which has a hand of its own, and
/// 'right', which uses the scene's; and scene 'other', without hands.
class Offering : public testing::Test {
 protected:
  std::vector<OfferedTool> Ask(const std::string& scene) {
    PointTo(of_scene, scenes[0].hand);
    PointTo(of_left, tools[0].hand);
    PointTo(tools, scenes[0].tools);
    PointTo(others, scenes[1].tools);
    PointTo(scenes, offer.scenes);
    EXPECT_TRUE(writer.Write(offer));
    return AskForTools(service, {kToolsDomain, {}, 10.0}, scene, stop);
  }
  Offering() {
    wire::FromText("mine", scenes[0].scene);
    wire::FromText("own.json", scenes[0].file);
    wire::FromText("other", scenes[1].scene);
    wire::FromText("left", tools[0].tool);
    wire::FromText("right", tools[1].tool);
    wire::FromText("ball", others[0].tool);
    wire::FromText("no hand was made", others[0].remark);
    for (auto* list : {&tools, &others}) {
      for (wire::OfferedTool& tool : *list) tool.start_orientation_wxyz[0] = 1.0;
    }
    others[0].start_position_m[2] = 0.25;
  }

  std::vector<wire::HandKey> of_scene{Key(0.0, 0.1), Key(1.0, 0.0)};
  std::vector<wire::HandKey> of_left{Key(0.0, 0.3), Key(2.0, 0.0)};
  std::vector<wire::OfferedTool> tools{2}, others{1};
  std::vector<wire::OfferedScene> scenes{2};
  wire::SceneOffer offer{};
  StopSignal stop;
  dds::Participant service = dds::Participant::Service(kToolsDomain);
  dds::Writer<wire::SceneOffer> writer{service, dds::kSceneOfferTopic, dds::Qos::kSession};
};

TEST_F(Offering, IsFoundByTheScenesNameAndByItsFile) {
  for (const std::string name : {"mine", "own.json", "./own.json", "/elsewhere/own.json"}) {
    const std::vector<OfferedTool> found = Ask(name);
    ASSERT_EQ(found.size(), 2u) << name;
    EXPECT_EQ(found[0].scene, "mine");
    EXPECT_EQ(found[0].tool, "left");
    EXPECT_EQ(found[0].Start().p.y(), 0.3) << "its own hand";
    EXPECT_EQ(found[1].Start().p.y(), 0.1) << "the scene's";
    EXPECT_EQ(found[1].hand->LabelAt(0.5), "press");
  }
  EXPECT_EQ(Ask("").size(), 3u);
}

TEST_F(Offering, WithoutAHandHasItsStartAndSaysWhy) {
  const std::vector<OfferedTool> found = Ask("other");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].hand);
  EXPECT_EQ(found[0].Start().p.z(), 0.25);
  EXPECT_EQ(found[0].remark, "no hand was made");
}

TEST_F(Offering, OfAHandThatNobodyCanFollowIsRefused) {
  of_left[1].position_m[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Ask("mine"), Error);
  of_left[1] = Key(2.0, 0.0);
  of_left[1].orientation_wxyz[0] = 0.0;
  EXPECT_THROW(Ask("mine"), Error);
  of_left[1] = Key(0.0, 0.0);
  EXPECT_THROW(Ask("mine"), Error) << "not after the key before";
}

TEST_F(Offering, NamesWhatThereIsWhereTheSceneIsNot) {
  EXPECT_THAT(ComplaintOf([&] { Ask("yours"); }),
              HasSubstr("scene 'yours' is not served here; choose one of: mine, other, "
                        "or start palpate-server with yours"));
}

TEST(AskForTools, SaysThatTheServerIsOfAnotherVersion) {
  const dds::Participant server = dds::Participant::Service(kToolsDomain);
  const dds::Writer<wire::ToolState> others(server, dds::kSceneOfferTopic, dds::Qos::kSession);
  const dds::Participant station = dds::Participant::Service(kToolsDomain);
  const std::string complaint = ComplaintOf([&] {
    AskForTools(station, {kToolsDomain, {}, 0.1}, "cube",
                [](std::chrono::nanoseconds) { return false; });
  });
  EXPECT_EQ(complaint, AnotherVersionIsThere(kToolsDomain)) << "what it cannot read is no offer";
  EXPECT_THAT(complaint, HasSubstr("of another version than this program (" PALPATE_VERSION));
}

TEST(NobodyAnswers, SaysWhatToStartAndWhere) {
  EXPECT_THAT(NobodyAnswers(7, {}, "mine"),
              HasSubstr("start 'palpate-server --scene mine --domain 7'"));
  dds::Network eth;
  eth.interface = "eth0";
  EXPECT_THAT(NobodyAnswers(7, eth, ""),
              HasSubstr("over eth0; start 'palpate-server --scene cube --domain 7 --network"));
}

}  // namespace
}  // namespace palpate
