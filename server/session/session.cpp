#include "server/session/session.h"

#include <cmath>
#include <utility>

#include "common/math/rotation.h"
#include "server/physics/start_pose.h"

namespace palpate {
namespace {

constexpr std::int64_t kTryAgain_ns = 100'000'000;  // the search takes up to as long
// A further search is useless for a hand that rests inside an object, unless the objects changed.
constexpr std::int64_t kTryAtRest_ns = 1'000'000'000;
constexpr double kMoved_m = 2e-4;
constexpr double kTurned_rad = 1e-3;
constexpr double kNews_m = 2e-3;  // a change that a person at the device can follow

constexpr const char* kTakenText =
    "another hand's tool is where this one would begin; move them apart, and forces begin";

std::string InsideText(double depth_m) {
  return "the tool is " + std::to_string(std::lround(1e3 * depth_m)) +
         " mm inside an object; move the hand back until it is free, and forces begin";
}

}  // namespace

Session::Session(std::string station, std::uint64_t run, std::shared_ptr<const ServedTool> tool,
                 std::int64_t now_ns, const SessionClient& client, std::unique_ptr<ServoLoop> loop)
    : station_(std::move(station)),
      run_(run),
      tool_(std::move(tool)),
      client_(client),
      loop_(loop ? std::move(loop) : std::make_unique<ServoLoop>(tool_->model)),
      start_workspace_(std::in_place, tool_->model),
      heard_ns_(now_ns),
      asked_ns_(now_ns) {}

bool Session::Update(std::int64_t now_ns, bool may_start) {
  if (ended()) return false;
  loop_->ReadSnapshot(snapshot_);
  const std::uint64_t heard = loop_->heard() + unanswered_.load(std::memory_order_relaxed);
  if (heard != heard_) {
    heard_ = heard;
    heard_ns_ = now_ns;
  }
  if (now_ns - (heard_ == 0 ? asked_ns_ : heard_ns_) >
      (heard_ == 0 ? kFirstPose_ns : silence_ns())) {
    End(heard_ == 0 ? "no pose came within 5 s of the request"
                    : "no pose came for more than " + std::to_string(silence_ns() / 1'000'000) +
                          " ms: the station was held up, or the way from it is cut");
    return true;
  }
  if (heard_ == 0 && std::exchange(listeners_told_, listeners_) != listeners_) return true;
  // A poll after it was told: a recording then has it before it has the first force.
  if (std::exchange(start_waits_, false)) loop_->Start(X_WG_start_);
  // Read before the start: of a start and a MakeWhole, the loop does the start first.
  const bool made_whole = whole_wanted_ && loop_->made_whole();
  // And before the start, because a start may be void at once, and recordings need it.
  const std::uint32_t voids = loop_->voids();
  if (phase_ == palpate_SESSION_ACTIVE && !start_seen_ &&
      loop_->start_sequence() != former_start_) {
    start_seen_ = true;
    return true;
  }
  if (std::exchange(voids_, voids) != voids) {
    const bool began = start_seen_;
    BeginAgain();
    if (!began) {
      phase_ = palpate_SESSION_ACQUIRING;
      reason_ = kTakenText;
    }
    return true;
  }
  if (made_whole) BeginAgain();
  if (phase_ == palpate_SESSION_ACTIVE) return false;
  return may_start && wants_start(now_ns) && TryStart(now_ns);
}

bool Session::wants_start(std::int64_t now_ns) const {
  if (phase_ == palpate_SESSION_ACTIVE || ended() || whole_wanted_ || start_is_held_ ||
      !snapshot_.has_pose) {
    return false;
  }
  const Pose& X_WH = snapshot_.X_WH;
  if (phase_ == palpate_SESSION_WAITING) return true;
  const std::int64_t since_ns = now_ns - tried_ns_;
  if (since_ns < kTryAgain_ns) return false;
  return since_ns >= kTryAtRest_ns || (X_WH.p - X_WH_tried_.p).norm() > kMoved_m ||
         RotationLog(X_WH.q * X_WH_tried_.q.conjugate()).norm() > kTurned_rad;
}

bool Session::TryStart(std::int64_t now_ns) {
  tried_ns_ = now_ns;
  X_WH_tried_ = snapshot_.X_WH;
  const StartPose start =
      ResolveStart(tool_->model, snapshot_.X_WH, *start_workspace_, start_cuts_);
  if (!(start.depth <= kMaxStartDepth_m)) {
    phase_ = palpate_SESSION_ACQUIRING;
    const bool news = reason_.empty() || std::abs(start.depth - start_depth_) > kNews_m;
    start_depth_ = start.depth;
    reason_ = InsideText(start.depth);
    return news;
  }
  X_WG_start_ = start.X_WG;
  start_waits_ = true;
  start_workspace_.reset();
  start_depth_ = start.depth;
  phase_ = palpate_SESSION_ACTIVE;
  reason_.clear();
  return true;
}

bool Session::TakeWhole(wire::LoopWhole& whole) {
  if (!loop_->TakeWhole(whole.pose_sequence)) return false;
  wire::FromText(station_, whole.station);
  whole.run = run_;
  whole.number = ++wholes_;
  return true;
}

void Session::Begin(const std::vector<CutField>& cuts, bool has_all) {
  if (has_all) loop_->cuts() = cuts;
  start_is_held_ = !has_all;
  start_cuts_ = cuts;
}

void Session::Leave() {
  left_ = true;
  End("the station left");
}

void Session::MakeWhole() {
  if (whole_wanted_ && loop_->was_given_nothing())
    return;  // another was requested before the loop could begin again
  whole_wanted_ = true;
  start_waits_ = false;
  loop_->MakeWhole();
}

void Session::BeginAgain() {
  whole_wanted_ = false;
  former_start_ = loop_->start_sequence();
  start_seen_ = false;
  if (!start_workspace_) start_workspace_.emplace(tool_->model);
  phase_ = palpate_SESSION_WAITING;
  reason_.clear();
}

void Session::End(std::string reason) {
  phase_ = palpate_SESSION_ENDED;
  reason_ = std::move(reason);
}

}  // namespace palpate
