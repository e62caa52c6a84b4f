#include "server/session/session_table.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "tests/session/ball_tool.h"
#include "tests/session/block_scene.h"
#include "tests/session/session_request.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::string NumberedName(std::size_t number) {
  const std::string text = std::to_string(number);
  return "s" + text;
}

class SessionTableTest : public testing::Test {
 protected:
  /// Returns the last state that the request led to.
  wire::SessionState Ask(const wire::SessionRequest& request) {
    table_.Request(request, now_);
    return LastChange();
  }
  wire::SessionState LastChange() {
    const auto changes = table_.TakeChanges();
    if (changes.empty()) return wire::SessionState{};
    EXPECT_EQ(changes.back().server_run, kServerRun);
    return changes.back();
  }
  bool Holds(const std::string& station, std::uint64_t run) const {
    const auto it = table_.sessions().find(station);
    return it != table_.sessions().end() && it->second->run() == run;
  }
  /// Station "a" drives scene "one" and sends poses for `milliseconds`.
  void Begin(int milliseconds) {
    Ask(MakeRequest("a", 1, "one"));
    Pass(milliseconds, {"a"});
  }
  void Leave(wire::SessionRequest request) {
    request.leave = true;
    table_.Request(request, now_);
    table_.Update(now_);
  }
  /// Lets time pass while the named stations send a pose a millisecond.
  void Pass(int milliseconds, const std::vector<std::string>& sending) {
    for (int i = 0; i < milliseconds; ++i) {
      for (const std::string& station : sending) {
        const auto it = table_.sessions().find(station);
        if (it == table_.sessions().end()) continue;
        wire::Wrench answer{};
        it->second->loop().OnPose(hand_.At(0.2), answer);
      }
      table_.Update(now_ += kMs);
    }
  }

  std::int64_t now_ = 1000 * kMs;
  Hand hand_;
  SessionTable table_{{BallTool("one", "probe", Vec3(0.1, 0.2, 0.3)), BallTool("two", "left"),
                       BallTool("two", "right")},
                      kServerRun};
};

TEST_F(SessionTableTest, AdmitsAStationToTheOnlyToolOfAScene) {
  const wire::SessionState state = Ask(MakeRequest("a", 5, "one"));
  EXPECT_EQ(state.phase, palpate_SESSION_WAITING);
  EXPECT_STREQ(state.station, "a");
  EXPECT_EQ(state.run, 5u);
  EXPECT_STREQ(state.tool, "probe");
  EXPECT_EQ(wire::ToVec3(state.tool_reference_m), Vec3(0.1, 0.2, 0.3));
}

TEST_F(SessionTableTest, RefusesWhatCannotBeHadAndSaysWhatThereIs) {
  Ask(MakeRequest("a", 1, "two", "left"));
  for (const auto& [request, reason] :
       std::initializer_list<std::pair<wire::SessionRequest, std::string>>{
           {MakeRequest("b", 1, "two", "left"), "'left' of scene 'two' is driven by station 'a'"},
           {MakeRequest("b", 1, "three"), "'three' is not served here.*one, two"},
           {MakeRequest("b", 1, "two", "middle"),
            "tool 'middle' is not in scene 'two'.*left, right"},
           {MakeRequest("b", 1, "two"), "several tools"},
           {MakeRequest("a/b", 1, "one"), "not a valid name of a station"},
           {MakeRequest("", 1, "one"), "not a valid name of a station"}}) {
    const wire::SessionState state = Ask(request);
    EXPECT_EQ(state.phase, palpate_SESSION_REFUSED) << reason;
    EXPECT_THAT(state.reason, testing::ContainsRegex(reason));
    EXPECT_FALSE(Holds("b", 1));
  }
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, FreesTheToolWhenItsStationLeaves) {
  Ask(MakeRequest("a", 1, "one"));
  Leave(MakeRequest("a", 1, "one"));
  EXPECT_EQ(LastChange().phase, palpate_SESSION_ENDED);
  EXPECT_THAT(table_.sessions(), IsEmpty());
  EXPECT_EQ(Ask(MakeRequest("b", 1, "one")).phase, palpate_SESSION_WAITING);
}

TEST_F(SessionTableTest, IsNotMovedByALeaveOfAnotherRun) {
  Ask(MakeRequest("a", 1, "one"));
  Leave(MakeRequest("a", 2, "one"));
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, FreesTheToolWhenItsStationFallsSilent) {
  Begin(50);
  EXPECT_EQ(LastChange().phase, palpate_SESSION_ACTIVE);
  Pass(150, {});
  const wire::SessionState state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_ENDED);
  EXPECT_EQ(state.run, 1u);
  EXPECT_EQ(Ask(MakeRequest("b", 1, "one")).phase, palpate_SESSION_WAITING);
}

TEST_F(SessionTableTest, TakesARestartedStationOnceItsFormerRunIsSilent) {
  Begin(50);
  LastChange();
  table_.Request(MakeRequest("a", 2, "one"), now_);
  EXPECT_TRUE(Holds("a", 1));
  Pass(150, {});
  EXPECT_TRUE(Holds("a", 2));
  EXPECT_EQ(LastChange().run, 2u);
}

TEST_F(SessionTableTest, RefusesASecondStationUnderTheNameOfOneThatLives) {
  Begin(50);
  table_.Request(MakeRequest("a", 2, "two", "left"), now_);
  Pass(400, {"a"});
  const auto changes = table_.TakeChanges();
  ASSERT_GE(changes.size(), 2u);
  const wire::SessionState& state = changes[changes.size() - 2];
  EXPECT_EQ(state.phase, palpate_SESSION_REFUSED);
  EXPECT_EQ(state.run, 2u);
  EXPECT_THAT(state.reason, HasSubstr("another --id"));
  EXPECT_EQ(changes.back().run, 1u) << "who comes later learns who drives";
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, LeavesARunThatHasSentNoPoseYetTheTimeForItsFirst) {
  constexpr int kFirstPose_ms = Session::kFirstPose_ns / kMs;
  Ask(MakeRequest("a", 1, "one"));
  table_.Request(MakeRequest("a", 2, "one"), now_);
  Pass(kFirstPose_ms, {});
  EXPECT_TRUE(Holds("a", 1));
  EXPECT_EQ(LastChange().run, 0u) << "nothing is decided yet";
  Pass(2, {});
  EXPECT_TRUE(Holds("a", 2)) << "the first has proved dead";
}

TEST_F(SessionTableTest, RefusesAStrangerUnderTheNameOfARunWhoseFirstPoseComes) {
  Ask(MakeRequest("a", 1, "one"));
  table_.Request(MakeRequest("a", 2, "one"), now_);
  Pass(2000, {});
  Pass(2, {"a"});
  const auto changes = table_.TakeChanges();
  const auto refused = std::ranges::find(changes, 2u, &wire::SessionState::run);
  ASSERT_NE(refused, changes.end());
  EXPECT_EQ(refused->phase, palpate_SESSION_REFUSED);
  EXPECT_THAT(refused->reason, HasSubstr("another --id"));
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, IsNotEndedByAStrangerWhileItsSceneIsMadeWhole) {
  SessionTable table(BlockTools(), kServerRun);
  table.Request(MakeRequest("a", 1, "block", "bur"), now_);
  const auto pass = [&](int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      wire::Wrench answer{};
      table.sessions().at("a")->loop().OnPose(hand_.At(0.2), answer);
      table.Update(now_ += kMs);
    }
  };
  pass(10);
  wire::WholeRequest wish{};
  wire::FromText("block", wish.scene);
  table.Request(wish);
  wire::Wrench answer{};
  Session& session = *table.sessions().at("a");
  session.loop().OnPose(hand_.At(0.2), answer);
  session.loop().OnPose(hand_.At(0.2), answer);
  session.Update(now_, false);
  ASSERT_EQ(session.phase(), palpate_SESSION_WAITING) << "it begins anew";
  table.Request(MakeRequest("a", 2, "block", "bur"), now_);
  pass(400);
  EXPECT_EQ(table.sessions().at("a")->run(), 1u);
  EXPECT_EQ(table.sessions().at("a")->phase(), palpate_SESSION_ACTIVE);
}

TEST_F(SessionTableTest, LetsNoStrangerTakeThePlaceOfOneThatWaitsForAFormerRun) {
  Begin(50);
  table_.Request(MakeRequest("a", 2, "one"), now_);
  table_.Request(MakeRequest("a", 3, "one"), now_);
  Pass(150, {});
  EXPECT_TRUE(Holds("a", 2));
}

TEST_F(SessionTableTest, TellsAgainWhereARunAsksAgain) {
  Begin(50);
  LastChange();
  EXPECT_EQ(Ask(MakeRequest("a", 1, "one")).phase, palpate_SESSION_ACTIVE);
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, TellsOnceMoreFromWhichPoseAndPlaceForcesAreComputed) {
  Begin(1);
  wire::SessionState state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_ACTIVE);
  EXPECT_EQ(state.start_sequence, 0u) << "no pose has come since";
  Pass(2, {"a"});
  state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_ACTIVE);
  EXPECT_EQ(state.start_sequence, 3u) << "a poll after the start was told";
  EXPECT_EQ(wire::ToVec3(state.start_position_m), Vec3(0, 0, 0.2));
  EXPECT_EQ(state.start_orientation_wxyz[0], 1.0);
  Pass(50, {"a"});
  EXPECT_EQ(LastChange().run, 0u) << "told again though nothing is new";
}

TEST_F(SessionTableTest, ServesASceneAsOftenAsItHasSeatsWithOneModel) {
  const auto first = BallTool("one");
  const auto second = std::make_shared<const ServedTool>(first->In("one-1"));
  EXPECT_EQ(&first->model, &second->model);
  SessionTable table({first, second}, kServerRun);
  table.Request(MakeRequest("a", 1, "one"), now_);
  table.Request(MakeRequest("b", 2, "one-1"), now_);
  EXPECT_EQ(table.sessions().size(), 2u);
  EXPECT_EQ(table.TakeChanges().back().scene, std::string("one-1"));
}

TEST_F(SessionTableTest, HoldsItsMostStationsAndNoMore) {
  std::vector<std::shared_ptr<const ServedTool>> tools;
  constexpr int kTools = SessionTable::kMaxStations + 1;
  for (int i = 0; i < kTools; ++i) tools.push_back(BallTool("many", "tool" + std::to_string(i)));
  SessionTable table(std::move(tools), kServerRun);
  for (int i = 0; i < kTools; ++i) {
    const std::string number = std::to_string(i);
    table.Request(MakeRequest("s" + number, 1, "many", "tool" + number), now_);
  }
  EXPECT_EQ(table.sessions().size(), SessionTable::kMaxStations);
  const auto changes = table.TakeChanges();
  EXPECT_EQ(changes.back().phase, palpate_SESSION_REFUSED);
  EXPECT_THAT(changes.back().reason,
              HasSubstr(std::to_string(SessionTable::kMaxStations) + " stations"));
}

TEST_F(SessionTableTest, KeepsARequestThatALeaveOfTheRunBeforeOvertakes) {
  Begin(10);
  table_.Request(MakeRequest("a", 2, "one"), now_);
  Leave(MakeRequest("a", 1, "one"));
  Pass(10, {});
  EXPECT_TRUE(Holds("a", 2));
}

wire::SessionRequest Sealed(wire::SessionRequest request, std::uint8_t key) {
  std::ranges::fill(request.leave_key, key);
  std::ranges::copy(dds::SealOf(request.leave_key), request.leave_seal);
  return request;
}

TEST_F(SessionTableTest, IsEndedByNobodyWhoLacksTheKeyOfItsRequest) {
  const wire::SessionRequest asked = Sealed(MakeRequest("a", 1, "one"), 7);
  wire::SessionRequest request = asked;
  std::ranges::fill(request.leave_key, 0);  // as it travels
  Ask(request);
  Pass(10, {"a"});
  wire::SessionRequest leave = request;
  leave.leave = true;
  for (int key = 0; key < 256; ++key) {
    if (key == 7) continue;
    std::ranges::fill(leave.leave_key, static_cast<std::uint8_t>(key));
    table_.Request(leave, now_);
  }
  std::ranges::copy(request.leave_seal, leave.leave_key);
  table_.Request(leave, now_);
  table_.Update(now_);
  ASSERT_TRUE(Holds("a", 1));
  Leave(asked);
  EXPECT_FALSE(Holds("a", 1));
}

TEST_F(SessionTableTest, IsNotRefusedBySomebodysWordInItsName) {
  Begin(10);
  const wire::SessionState state = Ask(MakeRequest("a", 1, "three"));
  EXPECT_NE(state.phase, palpate_SESSION_REFUSED);
  EXPECT_STREQ(state.scene, "one");
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, TellsSoManyRefusalsAtOnceAndASecondAndCountsTheRest) {
  const auto flood = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      table_.Request(MakeRequest(NumberedName(i), 1, "three"), now_);
    }
    return table_.TakeChanges().size();
  };
  EXPECT_EQ(flood(80'000), SessionTable::kRefusalsAtOnce);
  EXPECT_EQ(table_.TakeUntold(), 80'000 - SessionTable::kRefusalsAtOnce);
  EXPECT_EQ(table_.TakeUntold(), 0u);
  now_ += 1000 * kMs;
  EXPECT_EQ(flood(80'000), SessionTable::kRefusalsPerSecond);
  // A station that can have what it asks for is not held up.
  EXPECT_EQ(Ask(MakeRequest("a", 1, "one")).phase, palpate_SESSION_WAITING);
}

wire::OperateRequest MakeWish(const std::string& station, wire::OperateWish wish) {
  wire::OperateRequest request{};
  wire::FromText(station, request.station);
  request.server_run = kServerRun;
  static std::uint64_t number = 0;
  request.request = ++number;
  request.wish = wish;
  wire::FromText("the teacher", request.by);
  return request;
}

TEST_F(SessionTableTest, TakesAToolBackAndHoldsItsStationUntilItIsAdmittedAgain) {
  Begin(10);
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_TAKE_BACK), now_));
  table_.Update(now_);
  wire::SessionState state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_ENDED);
  EXPECT_THAT(state.reason, HasSubstr("taken back by the teacher"));
  // A station asks again by itself.
  state = Ask(MakeRequest("a", 2, "one"));
  EXPECT_EQ(state.phase, palpate_SESSION_HELD);
  EXPECT_THAT(state.reason, HasSubstr("the teacher"));
  EXPECT_EQ(Ask(MakeRequest("b", 1, "one")).phase, palpate_SESSION_WAITING) << "the tool is free";
  Leave(MakeRequest("b", 1, "one"));
  LastChange();
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_ADMIT), now_));
  state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_WAITING);
  EXPECT_EQ(state.run, 2u);
}

TEST_F(SessionTableTest, HoldsTheSuccessorOfAStationThatIsTakenBack) {
  Begin(10);
  table_.Request(MakeRequest("a", 2, "one"), now_);
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_TAKE_BACK), now_));
  table_.Update(now_);
  const wire::SessionState state = LastChange();
  EXPECT_EQ(state.phase, palpate_SESSION_HELD);
  EXPECT_EQ(state.run, 2u);
  EXPECT_THAT(table_.sessions(), IsEmpty());
}

TEST_F(SessionTableTest, RefusesAHeldStationThatIsTakenBack) {
  SessionTable table({BallTool("one")}, kServerRun, true);
  table.Request(MakeRequest("a", 1, "one"), now_);
  EXPECT_EQ(table.TakeChanges().back().phase, palpate_SESSION_HELD);
  table.Operate(MakeWish("a", palpate_OPERATE_TAKE_BACK), now_);
  const wire::SessionState state = table.TakeChanges().back();
  EXPECT_EQ(state.phase, palpate_SESSION_REFUSED);
  EXPECT_THAT(state.reason, HasSubstr("not admitted by the teacher"));
}

TEST_F(SessionTableTest, HoldsEachNewcomerWhereStationsAreAdmittedByHand) {
  SessionTable table({BallTool("one")}, kServerRun, true);
  table.Request(MakeRequest("a", 1, "one"), now_);
  table.Update(now_ += 1000 * kMs);
  EXPECT_EQ(table.TakeChanges().back().phase, palpate_SESSION_HELD);
  EXPECT_THAT(table.sessions(), IsEmpty());
  EXPECT_TRUE(table.Operate(MakeWish("a", palpate_OPERATE_ADMIT), now_));
  EXPECT_EQ(table.sessions().size(), 1u);
  // The name is known from then on, so a station that lost its server is let in again.
  table.EndAll("");
  table.TakeChanges();
  table.Request(MakeRequest("a", 2, "one"), now_);
  EXPECT_EQ(table.TakeChanges().back().phase, palpate_SESSION_WAITING);
}

/// A server that admits stations by hand, where one named "a" waits.
class HeldStationTest : public SessionTableTest {
 protected:
  HeldStationTest() {
    asked_ = Sealed(MakeRequest("a", 1, "two", "left"), 7);
    std::ranges::fill(asked_.leave_key, 0);  // as it travels
    by_hand_.Request(asked_, now_);
    EXPECT_EQ(by_hand_.TakeChanges().back().phase, palpate_SESSION_HELD);
  }
  /// Lets time pass; while it lives, the station asks again every 2 s.
  void Wait(int milliseconds, bool lives) {
    for (int i = 0; i < milliseconds; ++i) {
      by_hand_.Update(now_ += kMs);
      if (lives && i % 2000 == 1999) by_hand_.Request(asked_, now_);
    }
  }
  /// Admits the name as a teacher does.  Returns the run that then has a session; 0: none.
  std::uint64_t AdmittedRun() {
    by_hand_.Operate(MakeWish("a", palpate_OPERATE_ADMIT), now_);
    const auto session = by_hand_.sessions().find("a");
    return session == by_hand_.sessions().end() ? 0 : session->second->run();
  }

  SessionTable by_hand_{{BallTool("two", "left"), BallTool("two", "right")}, kServerRun, true};
  wire::SessionRequest asked_;
};

TEST_F(HeldStationTest, KeepsItsNameWhileItLives) {
  by_hand_.Request(MakeRequest("a", 2, "two", "right"), now_);
  EXPECT_THAT(by_hand_.TakeChanges(), IsEmpty()) << "nobody knows yet which of the two lives";
  Wait(2001, true);
  const auto changes = by_hand_.TakeChanges();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].run, 2u);
  EXPECT_EQ(changes[0].phase, palpate_SESSION_REFUSED);
  EXPECT_THAT(changes[0].reason, HasSubstr("'a' waits to be admitted; give another --id"));
  EXPECT_EQ(changes[1].run, 1u) << "who comes later learns who waits";
  EXPECT_EQ(changes[1].phase, palpate_SESSION_HELD);
  EXPECT_EQ(AdmittedRun(), 1u);
}

TEST_F(HeldStationTest, IsAdmittedThoughAStrangerAsksInTheMeantime) {
  by_hand_.Request(MakeRequest("a", 2, "two", "right"), now_);
  EXPECT_EQ(AdmittedRun(), 1u);
  EXPECT_EQ(by_hand_.sessions().at("a")->tool().tool, "left");
}

TEST_F(HeldStationTest, DrivesWhatItAskedForWhoeverRepeatsItsPublicRun) {
  wire::SessionRequest stranger = MakeRequest("a", 1, "two", "right");
  by_hand_.Request(stranger, now_);
  std::ranges::copy(asked_.leave_seal, stranger.leave_seal);
  by_hand_.Request(stranger, now_);
  ASSERT_EQ(AdmittedRun(), 1u);
  EXPECT_EQ(by_hand_.sessions().at("a")->tool().tool, "left");
  EXPECT_EQ(by_hand_.sessions().at("a")->leave_seal(), std::to_array(asked_.leave_seal));
}

TEST_F(HeldStationTest, IsTakenBackByNobodyWhoLacksItsKey) {
  wire::SessionRequest leave = asked_;
  leave.leave = true;
  std::ranges::copy(asked_.leave_seal, leave.leave_key);
  by_hand_.Request(leave, now_);
  EXPECT_EQ(AdmittedRun(), 1u);
}

TEST_F(HeldStationTest, FreesItsNameWhenItLeaves) {
  by_hand_.Request(MakeRequest("a", 2, "two", "left"), now_);
  wire::SessionRequest leave = Sealed(MakeRequest("a", 1, "two", "left"), 7);
  leave.leave = true;
  by_hand_.Request(leave, now_);
  by_hand_.Update(now_);
  EXPECT_EQ(by_hand_.TakeChanges().back().phase, palpate_SESSION_HELD) << "its successor waits now";
  EXPECT_EQ(AdmittedRun(), 2u);
}

TEST_F(HeldStationTest, GivesItsNameToASuccessorWhenItAsksNoMore) {
  Wait(1000, false);
  by_hand_.Request(MakeRequest("a", 2, "two", "left"), now_);
  Wait(SessionTable::kHeldAwaited_ns / kMs - 1000, false);
  EXPECT_THAT(by_hand_.TakeChanges(), IsEmpty());
  Wait(1, false);
  const auto changes = by_hand_.TakeChanges();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].phase, palpate_SESSION_ENDED);
  EXPECT_EQ(changes[1].phase, palpate_SESSION_HELD) << "no newcomer passes the teacher by";
  EXPECT_EQ(AdmittedRun(), 2u);
}

TEST_F(SessionTableTest, HoldsNoMoreStationsThanItServes) {
  SessionTable table({BallTool("one")}, kServerRun, true);
  for (std::size_t i = 0; i <= SessionTable::kMaxStations; ++i) {
    table.Request(MakeRequest(NumberedName(i), 1, "one"), now_);
  }
  EXPECT_EQ(table.TakeChanges().back().phase, palpate_SESSION_REFUSED);
}

TEST_F(SessionTableTest, GivesThePlacesOfHeldStationsThatAskNoMoreToOthers) {
  SessionTable table({BallTool("one")}, kServerRun, true);
  for (std::size_t i = 0; i < SessionTable::kMaxStations; ++i) {
    table.Request(MakeRequest(NumberedName(i), 1, "one"), now_);
  }
  now_ += SessionTable::kHeld_ns;
  table.Request(MakeRequest(NumberedName(0), 1, "one"), now_);
  table.TakeChanges();
  table.Update(now_ += kMs);
  const std::vector<wire::SessionState> gone = table.TakeChanges();
  EXPECT_EQ(gone.size(), SessionTable::kMaxStations - 1) << "one asks still";
  EXPECT_EQ(gone.back().phase, palpate_SESSION_ENDED);
  table.Request(MakeRequest("pupil", 1, "one"), now_);
  EXPECT_EQ(table.TakeChanges().back().phase, palpate_SESSION_HELD);
}

TEST_F(SessionTableTest, TellsWhoeverAsksWithoutAnEndNoMoreThanItMust) {
  SessionTable by_hand({BallTool("one")}, kServerRun, true);
  SessionTable open({BallTool("one")}, kServerRun);
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    by_hand.Request(MakeRequest("held", i, "one"), now_);
    open.Request(MakeRequest("same", 1, "one"), now_);
  }
  EXPECT_LE(by_hand.TakeChanges().size(), SessionTable::kRefusalsAtOnce);
  EXPECT_LE(open.TakeChanges().size(), 1 + SessionTable::kRefusalsAtOnce);
}

TEST_F(SessionTableTest, KeepsAStationMutedWhateverSessionsComeAndGo) {
  Begin(10);
  EXPECT_FALSE(LastChange().muted);
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_MUTE), now_));
  EXPECT_TRUE(LastChange().muted);
  Pass(200, {});
  EXPECT_TRUE(Ask(MakeRequest("a", 2, "one")).muted) << "it would unmute itself";
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_UNMUTE), now_));
  EXPECT_FALSE(LastChange().muted);
}

TEST_F(SessionTableTest, DoesNoWishTwiceThatIsHeardTwice) {
  Begin(10);
  const wire::OperateRequest unmute = MakeWish("a", palpate_OPERATE_UNMUTE);
  const wire::OperateRequest admit = MakeWish("a", palpate_OPERATE_ADMIT);
  EXPECT_TRUE(table_.Operate(unmute, now_));
  EXPECT_TRUE(table_.Operate(admit, now_));
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_MUTE), now_));
  EXPECT_FALSE(table_.Operate(unmute, now_)) << "replayed, or told again by a gateway that is back";
  EXPECT_TRUE(LastChange().muted);
  EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_TAKE_BACK), now_));
  table_.Update(now_);
  EXPECT_FALSE(table_.Operate(admit, now_));
  EXPECT_EQ(Ask(MakeRequest("a", 2, "one")).phase, palpate_SESSION_HELD);
  // Other wishes are carried out, however many there were; very old ones are forgotten.
  for (std::size_t i = 0; i <= RequestMemory::kMost; ++i) {
    EXPECT_TRUE(table_.Operate(MakeWish("a", palpate_OPERATE_MUTE), now_));
  }
}

TEST_F(SessionTableTest, DoesNothingForAnotherServersTeacherOrAStationThatIsNotHere) {
  Ask(MakeRequest("a", 1, "one"));
  wire::OperateRequest other = MakeWish("a", palpate_OPERATE_TAKE_BACK);
  other.server_run = kServerRun + 1;
  EXPECT_FALSE(table_.Operate(other, now_));
  for (std::size_t i = 0; i < 10'000; ++i) {
    EXPECT_FALSE(table_.Operate(MakeWish(NumberedName(i), palpate_OPERATE_TAKE_BACK), now_));
  }
  EXPECT_TRUE(Holds("a", 1));
}

TEST_F(SessionTableTest, TellsEveryStationWhenTheServerStops) {
  Ask(MakeRequest("a", 1, "one"));
  Ask(MakeRequest("b", 1, "two", "left"));
  table_.EndAll("the server stops");
  const auto changes = table_.TakeChanges();
  ASSERT_EQ(changes.size(), 2u);
  for (const wire::SessionState& state : changes) {
    EXPECT_EQ(state.phase, palpate_SESSION_ENDED);
    EXPECT_STREQ(state.reason, "the server stops");
  }
}

}  // namespace
}  // namespace palpate::test
