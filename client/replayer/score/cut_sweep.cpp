#include "client/replayer/score/cut_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/bur_button.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/dds/wire.h"
#include "common/error.h"
#include "common/math/rotation.h"
#include "common/step_fault.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "server/session/servo_loop.h"

namespace palpate {
namespace {

/// Number of answers that may wait: poses, answers and session messages arrive separately.
constexpr std::size_t kWaiting = 1000;
/// Faults with which the loop took no step.
constexpr std::uint32_t kNoStep = kFaultBadPose | kFaultPoseRejected | kFaultNotStarted;

const Body& ToolOf(const Scene& scene, const std::string& name) {
  const auto tool = std::ranges::find(scene.tools, name, &Body::name);
  if (tool == scene.tools.end()) {
    throw Error("scene '" + scene.name + "' has no tool '" + name +
                "': the recording is of another scene of that name");
  }
  return *tool;
}

}  // namespace

CutSweep::CutSweep(const PlayedScene& played, const std::string& tool, std::string station,
                   std::uint64_t run)
    : station_(std::move(station)),
      poses_(dds::PoseTopic(station_, run)),
      wrenches_(dds::WrenchTopic(station_, run)),
      run_(run),
      model_(MakeModel(*played.scene, ToolOf(*played.scene, tool), played.objects)),
      state_(model_),
      cut_{played.scene, played.objects, state_.cut.fields, {}} {
  // Friction by the chapter's rule moves the tool again after the step.
  sure_ = played.scene->features.friction != FrictionModel::kChapter;
}

void CutSweep::Hear(const RecordedSample& sample) {
  if (*sample.topic == poses_ || *sample.topic == wrenches_) return HearOfLoop(sample);
  HearOfScene(sample);
}

void CutSweep::HearOfLoop(const RecordedSample& sample) {
  wire::HapticPose pose;
  wire::Wrench wrench;
  if (sample.To(pose)) {
    Pose X_WH = wire::ToPose(pose);
    // Twice, as the loop and the step do, for equal bits.
    for (int i = 0; i < 2; ++i) X_WH.q.coeffs() /= std::sqrt(X_WH.q.squaredNorm());
    const auto at = std::ranges::upper_bound(hands_, pose.pose_sequence, {}, &Hand::pose_sequence);
    hands_.insert(at, {pose.pose_sequence, X_WH, (pose.buttons & kStillBurButton) == 0});
  } else if (sample.To(wrench)) {
    answers_.push_back(wrench);
    Advance(kWaiting);
  } else {
    sure_ = false;
  }
}

void CutSweep::HearOfScene(const RecordedSample& sample) {
  wire::SessionState state{};
  wire::LoopWhole whole{};
  dds::Owned<wire::CutLog> log;
  if (sample.To(state) && state.station == station_ && state.run == run_) {
    if (state.phase == palpate_SESSION_REFUSED) return;
    scene_run_ = {state.scene, state.server_run};
    if (state.start_sequence == 0) return;
    const Pose start = wire::ToPose(state.start_position_m, state.start_orientation_wxyz);
    const bool is_new = starts_.try_emplace(state.start_sequence, start).second;
    sure_ = sure_ && (!is_new || state.start_sequence > last_pose_);
  } else if (sample.To(whole) && whole.station == station_ && whole.run == run_) {
    const bool is_new = wholes_.try_emplace(whole.number, whole.pose_sequence).second;
    sure_ = sure_ && (!is_new || whole.pose_sequence > last_pose_);
  } else if (sample.To(log.value)) {
    logs_[{log.value.scene, log.value.server_run}].Add(log.value);
  } else if (sample.type == RecordedType::kSolidBlock) {
    cut_before_ = cut_before_ || (answers_.empty() && last_answer_ == 0);
  }
}

void CutSweep::Advance(std::size_t left) {
  for (; sure_ && answers_.size() > left; answers_.pop_front()) {
    const wire::Wrench& answer = answers_.front();
    while (!hands_.empty() && hands_.front().pose_sequence < answer.pose_sequence) {
      hands_.pop_front();
    }
    const bool is_there = !hands_.empty() && hands_.front().pose_sequence == answer.pose_sequence;
    const bool has_begun = !starts_.empty() && starts_.begin()->first < answer.pose_sequence;
    // A missing answer leaves the tool's pose unknown.
    sure_ = is_there && (answer.answer == last_answer_ + 1 || !has_begun);
    if (sure_) Follow(hands_.front(), answer);
    last_answer_ = answer.answer;
    last_pose_ = answer.pose_sequence;
  }
}

void CutSweep::Follow(const Hand& hand, const wire::Wrench& answer) {
  const bool had_force = std::exchange(has_force_, (answer.faults & kFaultNotStarted) == 0);
  if (const auto start = starts_.find(hand.pose_sequence); start != starts_.end()) {
    state_.X_WG = start->second;
  } else if (has_force_ && !had_force) {
    sure_ = false;  // the recorder ended before it was told that forces began here
  }
  for (auto whole = wholes_.upper_bound(wholes_done_);
       whole != wholes_.end() && whole->second <= hand.pose_sequence; ++whole) {
    wholes_done_ = whole->first;
    for (CutField& cut : state_.cut.fields) cut.MakeWhole();
  }
  const Pose from = state_.X_WG;
  state_.X_WG = wire::ToPose(answer.graphic_position_m, answer.graphic_orientation_wxyz);
  if ((answer.faults & kNoStep) != 0) return;
  state_.cut.spins = hand.spins;
  state_.cut.acts = CutsInStep(model_, hand.X_WH, state_);
  state_.X_WH = hand.X_WH;
  if (state_.cut.acts && model_.cutting() != nullptr) {
    Sweep(from, state_.X_WG, (answer.faults & kFaultTargetFar) != 0);
  }
}

/// Removes the tool's path as Energies::Cut does: straight, without rotation.
void CutSweep::Sweep(const Pose& from, const Pose& to, bool stays_behind) {
  const Cutting& cutting = *model_.cutting();
  const Vec3 p_G = from * model_.reference();
  const Vec3 lever = from.q * (cutting.X_TB.p - model_.reference());
  const Vec3 step =
      to * model_.reference() - p_G + RotationLog(to.q * from.q.conjugate()).cross(lever);
  const Pose X_WB{p_G + lever, from.q * cutting.X_TB.q};
  for (std::size_t i = 0; i < state_.cut.fields.size(); ++i) {
    CutField& cut = state_.cut.fields[i];
    const Pose X_SW = model_.solids()[i].X_WB.Inverse(), X_SB = X_SW * X_WB;
    if (stays_behind || step.norm() > 0.5 * cut.field().band()) {
      const double near = step.norm() + cut.field().lattice().spacing;
      sure_ = sure_ && std::ranges::none_of(model_.bur_samples(), [&](const BurSample& sample) {
                return cut.Distance(X_SB * sample.point) < near;
              });
    }
    cut.Remove(cutting.bur, X_SB, X_SW.q * step);
  }
}

/// Returns whether nobody else cut there, before or meanwhile.
bool CutSweep::IsAlone() const {
  const auto log = scene_run_ ? logs_.find(*scene_run_) : logs_.end();
  if (log == logs_.end()) return logs_.empty() && !cut_before_;
  auto sessions = log->second.Sessions();
  const auto own = sessions.find({station_, run_});
  if (own == sessions.end()) return false;
  const CutFacts& facts = own->second;
  const bool has_all = !facts.ended || facts.ended->other == last_answer_;
  const bool knows_all = facts.known == std::numeric_limits<std::uint64_t>::max();
  if (!facts.merges.empty() || !has_all || !knows_all) return false;
  bool is_whole = true;
  for (const auto& event : log->second.Events()) {
    if (!event) return false;  // a part of the log is missing
    if (event->step == palpate_CUT_WHOLE) is_whole = true;
    if (event->step == palpate_CUT_BACK) return false;
    const bool is_own = event->session == facts.session;
    const bool gets_all = is_own && event->step == palpate_CUT_BEGUN && event->count > 0;
    if (gets_all && !is_whole) return false;
    const bool cuts = event->step == palpate_CUT_TAKEN || event->step == palpate_CUT_ENDED;
    if (cuts && event->count > 0) is_whole = false;
  }
  return true;
}

std::optional<SolidsCut> CutSweep::Finish() {
  Advance(0);
  if (!sure_ || last_answer_ == 0 || !IsAlone()) return std::nullopt;
  cut_.after = std::move(state_.cut.fields);
  return std::move(cut_);
}

}  // namespace palpate
