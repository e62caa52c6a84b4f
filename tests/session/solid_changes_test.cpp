#include "server/session/solid_changes.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <thread>

#include <gmock/gmock.h>

#include "scenes/grid/surface_code.h"
#include "server/session/session_table.h"
#include "tests/session/ball_tool.h"
#include "tests/session/block_scene.h"
#include "tests/session/session_request.h"
#include "tests/support/allocation_counter.h"

namespace palpate::test {
namespace {

/// How far strokes take the ball's middle below the face.
constexpr double kDepth = 0.2e-3;

wire::SessionRequest RequestOf(const std::string& station, bool leave = false) {
  return MakeRequest(station, 1, "block", "bur", leave);
}

class SolidChangesTest : public testing::Test {
 protected:
  void Begin(const std::string& station) {
    station_ = station;
    table_.Request(RequestOf(station), now_);
    table_.RetireEnded(now_);
    table_.Begin(*table_.sessions().at(station));
  }
  void Leave() {
    table_.Request(RequestOf(station_, true), now_);
    table_.Update(now_);
  }
  /// Moves the ball's middle to `to` in `milliseconds`, and collects what viewers are told
  /// meanwhile.
  void Move(const Vec3& to, int milliseconds) {
    const Vec3 from = at_;
    for (int ms = 1; ms <= milliseconds; ++ms) {
      at_ = from + ms * (to - from) / milliseconds;
      table_.sessions().at(station_)->loop().OnPose(hand_.At(at_ - Vec3(0, kBurRadius, 0)),
                                                    answer_);
      now_ += kMs;
      if (ms % 5 == 0) Poll();
    }
  }
  void Stroke() {
    Move({-2e-3, 0, 1e-3}, 200);  // forces ramp in
    Move({-2e-3, 0, -kDepth}, 200);
    Move({1e-3, 0, -kDepth}, 400);
  }
  void Poll() {
    table_.Update(now_);
    for (SolidBlockNews& news : table_.TakeCuts(now_)) {
      EXPECT_GT(news.sample.change, change_);
      EXPECT_STREQ(news.sample.scene, "block");
      EXPECT_EQ(news.sample.server_run, kServerRun);
      change_ = news.sample.change;
      bytes_ += 100.0 + static_cast<double>(news.surface.size());
      ++told_;
      shown_[news.sample.block] = std::move(news);
    }
  }
  /// Waits until nothing is left to be told.
  void Settle() {
    for (std::size_t before = told_ - 1; before != told_;) {
      before = told_;
      Move(at_, 200);
    }
  }
  ServoLoop& loop() { return table_.sessions().at(station_)->loop(); }
  const SolidGrid& grid() const { return *tools_[0]->model.solids()[0].grid; }

  std::vector<std::uint8_t> SurfaceOf(const SparseField& cut, std::size_t block) const {
    const Lattice& lattice = cut.lattice();
    const auto [i, j, k] = lattice.BlockAt(block);
    SolidSurface surface;
    TakeSurface(grid(), cut, block, surface);
    std::vector<std::uint8_t> code;
    EncodeSurface(surface, lattice.Point(8 * i, 8 * j, 8 * k), lattice.spacing, code);
    return code;
  }
  static bool IsCut(const SparseField& cut, std::size_t block) {
    const std::int32_t entry = cut.entry(block);
    if (entry < 0) return entry == SparseField::kAbove;
    const float* points = cut.values(entry);
    return std::any_of(points, points + SparseField::kPoints,
                       [&](float value) { return value > -cut.band(); });
  }
  static bool IsWhole(const SparseField& cut) {
    for (std::size_t block = 0; block < cut.lattice().block_count(); ++block) {
      if (IsCut(cut, block)) return false;
    }
    return true;
  }
  /// Viewers see what the loop feels; where they were told nothing, the surface is the original
  /// one.
  void ExpectShown(const SparseField& cut) {
    const SparseField whole(cut.lattice(), cut.band(), SparseField::kBelow);
    std::size_t cut_blocks = 0;
    for (std::size_t block = 0; block < cut.lattice().block_count(); ++block) {
      const auto shown = shown_.find(static_cast<std::uint32_t>(block));
      if (shown == shown_.end()) {
        ASSERT_EQ(SurfaceOf(cut, block), SurfaceOf(whole, block));
        continue;
      }
      ASSERT_EQ(shown->second.surface, SurfaceOf(cut, block));
      ASSERT_EQ(shown->second.sample.cut, IsCut(cut, block));
      cut_blocks += shown->second.sample.cut;
    }
    EXPECT_GT(cut_blocks, 20u);
  }

  /// Viewers are told the volume that is missing, as a score computes it.
  void ExpectRemoved(const CutField& cut) {
    const double whole = CutField(grid(), kMostGridBytes, "block").VolumeLeft()[0];
    const double gone_mm3 = 1e9 * (whole - cut.VolumeLeft()[0]);
    double told_mm3 = 0.0;
    for (const auto& [block, news] : shown_) {
      ASSERT_LE(news.removed_mm3.size(), 1u);
      for (const float removed : news.removed_mm3) told_mm3 += removed;
    }
    EXPECT_GT(gone_mm3, 0.1);
    EXPECT_NEAR(told_mm3, gone_mm3, 1e-5 * gone_mm3);
  }

  std::int64_t now_ = 1000 * kMs;
  std::vector<std::shared_ptr<const ServedTool>> tools_ = BlockTools();
  SessionTable table_{tools_, kServerRun};
  std::string station_;
  Hand hand_;
  Vec3 at_{-2e-3, 0, 2e-3};
  wire::Wrench answer_{};
  std::map<std::uint32_t, SolidBlockNews> shown_;
  std::uint64_t change_ = 0;
  std::size_t told_ = 0;
  double bytes_ = 0.0;
};

TEST_F(SolidChangesTest, ViewersAreShownWhatTheLoopFeels) {
  Begin("a");
  Stroke();
  EXPECT_GT(wire::ToWrench(answer_).force.norm(), 0.02);
  EXPECT_EQ(answer_.contacts, 1u);
  const LoopSnapshot& shown = table_.sessions().at("a")->snapshot();
  ASSERT_EQ(shown.points, 1);
  EXPECT_LT((shown.point[0].force - shown.wrench.force).norm(), 1e-9);
  EXPECT_LT((shown.point[0].point - shown.X_WG * Vec3(0, kBurRadius, 0)).norm(), 1e-9);
  EXPECT_EQ(answer_.rows, 0u) << "a force computed from rows would leave the cutting out";
  Settle();
  ExpectShown(loop().cuts()[0].field());
  for (const auto& [block, news] : shown_) {
    EXPECT_EQ(news.sample.object_index, 0u);
    EXPECT_EQ(wire::ToVec3(news.sample.origin_m), grid().field().lattice().origin);
  }
  ExpectRemoved(loop().cuts()[0]);
  // So deep that blocks within are gone which never had a surface that viewers saw.
  Move({1e-3, 0, -1.5e-3}, 1000);
  Settle();
  ExpectShown(loop().cuts()[0].field());
  ExpectRemoved(loop().cuts()[0]);
}

// At 20 mm/s a ball of 1.4 mm changes more than the budget lets through.
TEST_F(SolidChangesTest, CostAViewerNoMoreThanTheBudget) {
  Begin("a");
  Stroke();
  const double before = bytes_;
  for (const double y : {0.5e-3, -0.5e-3}) {
    Move({at_.x(), y, -kDepth}, 50);
    Move({-at_.x(), y, -kDepth}, 100);
  }
  const double most = SolidChanges::kBytesPerSecond * 0.3 + SolidChanges::kBytesAtOnce;
  EXPECT_LT(bytes_ - before, most + 2e3);  // what is sent first is paid for by waiting
  EXPECT_GT(bytes_ - before, 0.6 * most);
}

// The blocks behind the bur; the ones that it is in keep changing.
TEST_F(SolidChangesTest, AreToldWhenTheBurHasLeft) {
  Begin("a");
  Stroke();
  Settle();
  Move(at_ + Vec3(1.3e-3, 0, 0), 300);
  // Beyond the field's band and the stencil of a gradient, and 30 ms behind.
  const Vec3 left =
      wire::ToVec3(answer_.graphic_position_m) + Vec3(-kBurRadius - 0.7e-3, kBurRadius, 0);
  const SparseField& cut = loop().cuts()[0].field();
  const Lattice& lattice = cut.lattice();
  std::size_t behind = 0;
  for (const auto& [block, news] : shown_) {
    const int i = lattice.BlockAt(block)[0];
    if (lattice.Point(8 * i + 8, 0, 0).x() > left.x()) continue;
    ++behind;
    EXPECT_EQ(news.surface, SurfaceOf(cut, block)) << lattice.Point(8 * i, 0, 0).x();
  }
  EXPECT_GT(behind, 10u);
}

TEST_F(SolidChangesTest, TheNextSessionBeginsWithWhatIsLeft) {
  Begin("a");
  Stroke();
  const CutField cut = loop().cuts()[0];
  // At the bur's position; the hand, which presses, is deeper.
  at_ = wire::ToVec3(answer_.graphic_position_m) + Vec3(0, kBurRadius, 0);
  Leave();
  Begin("b");
  for (int k = 0; k < 8 * cut.field().lattice().blocks[2]; ++k) {
    for (int i = 0; i < 8 * cut.field().lattice().blocks[0]; ++i) {
      ASSERT_EQ(loop().cuts()[0].field().At(i, 18, k), cut.field().At(i, 18, k));
    }
  }
  // The hand is in the groove, where it is free: forces begin there.
  Move(at_ - Vec3(1e-3, 0, 0), 50);
  EXPECT_EQ(table_.sessions().at("b")->phase(), palpate_SESSION_ACTIVE);
  EXPECT_EQ(table_.sessions().at("b")->start_depth(), 0.0);
  Settle();
  ExpectShown(loop().cuts()[0].field());
}

TEST_F(SolidChangesTest, ASessionThatSentNoPoseLeavesWhatWasLeft) {
  Begin("a");
  Stroke();
  const SparseField cut = loop().cuts()[0].field();
  Leave();
  table_.RetireEnded(now_);
  // A session that is asked for and left before it begins.
  table_.Request(RequestOf("b"), now_);
  table_.Request(RequestOf("b", true), now_);
  table_.Update(now_);
  table_.RetireEnded(now_);
  Begin("c");
  for (std::size_t block = 0; block < cut.lattice().block_count(); ++block) {
    ASSERT_EQ(IsCut(loop().cuts()[0].field(), block), IsCut(cut, block));
  }
}

TEST_F(SolidChangesTest, ABlockThatWasNotTakenIsToldAgain) {
  Begin("a");
  Stroke();
  Settle();
  const auto [block, news] = *shown_.begin();
  shown_.clear();
  told_ = 0;
  table_.TellAgain(news.sample, now_);
  Settle();
  ASSERT_EQ(shown_.size(), 1u);
  EXPECT_EQ(shown_.begin()->first, block);
  EXPECT_EQ(shown_.begin()->second.surface, news.surface);
  EXPECT_GT(shown_.begin()->second.sample.change, news.sample.change);
}

TEST_F(SolidChangesTest, MadeWholeIsAsAtFirst) {
  wire::WholeRequest whole{};
  wire::FromText("block", whole.scene);
  whole.request = 1;
  Begin("a");
  Stroke();
  Move({1e-3, 0, 2e-3}, 4);  // into free space, so that nothing is cut anew
  table_.Request(whole);
  const auto wholes = table_.TakeWholes();
  ASSERT_EQ(wholes.size(), 1u);
  EXPECT_STREQ(wholes[0].refusal, "");
  EXPECT_GE(wholes[0].last_change, change_);
  // No older block is told any more, though the loop's last blocks were on their way.
  shown_.clear();
  told_ = 0;
  Move(at_, 100);
  EXPECT_EQ(told_, 0u);
  EXPECT_TRUE(IsWhole(loop().cuts()[0].field()));
  Move({-2e-3, 0, 2e-3}, 500);
  Stroke();
  Settle();
  ExpectShown(loop().cuts()[0].field());

  // The same between a session's end and the last of its poses.
  Move({1e-3, 0, 2e-3}, 4);
  Leave();
  whole.request = 2;
  table_.Request(whole);
  Begin("b");
  EXPECT_TRUE(IsWhole(loop().cuts()[0].field()));
  shown_.clear();
  told_ = 0;
  Move({-2e-3, 0, 2e-3}, 100);
  EXPECT_EQ(told_, 0u);
}

TEST_F(SolidChangesTest, AreRestoredByNobodyWhileAStationKeepsTheScene) {
  wire::WholeRequest wish{};
  wire::FromText("block", wish.scene);
  const auto refusal = [&](wire::WholeWish what) {
    wish.wish = what;
    ++wish.request;
    table_.Request(wish);
    return std::string(table_.TakeWholes().back().refusal);
  };
  EXPECT_EQ(refusal(palpate_WHOLE_BOOKMARK), "");
  wire::SessionRequest trial = RequestOf("a");
  trial.keeps_scene = true;
  table_.Request(trial, now_);
  table_.RetireEnded(now_);
  table_.Begin(*table_.sessions().at("a"));
  station_ = "a";
  Stroke();
  for (const auto what : {palpate_WHOLE_AGAIN, palpate_WHOLE_BOOKMARK, palpate_WHOLE_BACK}) {
    EXPECT_THAT(refusal(what), testing::HasSubstr("station 'a' is in a trial there"));
  }
  Move(at_, 100);
  EXPECT_FALSE(IsWhole(loop().cuts()[0].field())) << "and what it cut stays cut";
  Leave();
  EXPECT_EQ(refusal(palpate_WHOLE_BACK), "");
}

// With the loop in a thread of its own, as poses come in a server: in the end viewers have
// everything.
TEST_F(SolidChangesTest, AreToldWhileTheLoopCuts) {
  Begin("a");
  Move({-2e-3, 0, 1e-3}, 200);
  ServoLoop& cutting = loop();
  constexpr int kPoses = 600;
  std::atomic<int> sent{0};
  const std::int64_t began = now_;
  std::thread servo([&] {
    for (int ms = 1; ms <= kPoses; ++ms) {
      at_ = Vec3(-2e-3 + 5e-6 * ms, 0, std::max(-kDepth, 1e-3 - 6e-6 * ms));
      cutting.OnPose(hand_.At(at_ - Vec3(0, kBurRadius, 0)), answer_);
      sent = ms;
      std::this_thread::yield();
    }
  });
  for (; sent < kPoses; std::this_thread::yield()) {
    now_ = began + sent * kMs;
    Poll();
  }
  servo.join();
  Settle();
  ExpectShown(loop().cuts()[0].field());
}

TEST_F(SolidChangesTest, AreToldWithoutAskingForMemory) {
  Begin("a");
  Stroke();
  const std::uint64_t before = AllocationsOfThisThread();
  for (int i = 0; i < 50; ++i) {
    at_.x() += 2e-6;
    loop().OnPose(hand_.At(at_ - Vec3(0, kBurRadius, 0)), answer_);
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate::test
