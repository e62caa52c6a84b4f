#include "client/replayer/export/session_columns.h"

#include <algorithm>
#include <limits>

#include "client/replayer/playback.h"
#include "common/dds/phase_name.h"
#include "common/step_fault.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// A wrench may precede its pose in the recording, by at most a burst of samples.
constexpr std::size_t kMostAhead = 1000;
/// Poses without an answer that are kept: two seconds at 4 kHz, longer than a station waits.
constexpr std::size_t kMostUnanswered = 8192;

constexpr std::size_t kWordWidth = 16;
constexpr std::size_t kNameWidth = 64;
constexpr std::size_t kTextWidth = 512;

}  // namespace

SessionColumns::SessionColumns(const std::string& folder, ColumnFormat format)
    : poses_(folder + "/poses", format),
      wrenches_(folder + "/wrenches", format),
      faults_(folder + "/faults", format),
      tool_states_(folder + "/tool_states", format),
      contacts_(folder + "/contacts", format),
      phases_(folder + "/session", format),
      loop_(folder + "/loop", format),
      limiter_(folder + "/limiter", format),
      guide_(folder + "/guide", format) {}

std::vector<ColumnFile*> SessionColumns::tables() {
  return {&poses_,  &wrenches_, &faults_,  &tool_states_, &contacts_,
          &phases_, &loop_,     &limiter_, &guide_};
}

void SessionColumns::Add(const wire::HapticPose& pose, double time_s) {
  if (poses_.rows() == 0) first_sample_ns_ = pose.sample_time_ns;
  ColumnFile& t = poses_;
  t.Add("time_s", time_s);
  t.Add("pose_sequence", std::uint64_t{pose.pose_sequence});
  t.Add("station_time_s", SecondsBetween(first_sample_ns_, pose.sample_time_ns));
  t.AddPose("hand", pose.position_m, pose.orientation_wxyz);
  t.AddVector("hand_velocity", "m_per_s", pose.linear_velocity_m_s);
  t.AddVector("hand_turning", "rad_per_s", pose.angular_velocity_rad_s);
  t.Add("buttons", std::uint32_t{pose.buttons});
  t.Add("device_status", std::uint32_t{pose.device_status});
  t.EndRow();

  pose_times_s_[pose.pose_sequence] = time_s;
  if (pose_times_s_.size() > kMostUnanswered) pose_times_s_.erase(pose_times_s_.begin());
  WriteAnswered(false);
}

void SessionColumns::Add(const wire::Wrench& wrench, double time_s) {
  waiting_.push_back({wrench, time_s});
  WriteAnswered(false);
}

void SessionColumns::WriteAnswered(bool last) {
  while (!waiting_.empty()) {
    const auto pose = pose_times_s_.find(waiting_.front().wrench.pose_sequence);
    const bool known = pose != pose_times_s_.end();
    if (!known && !last && waiting_.size() <= kMostAhead) return;
    Write(waiting_.front(), known ? pose->second : std::numeric_limits<double>::quiet_NaN());
    // A loop answers poses in order.
    if (known) pose_times_s_.erase(pose_times_s_.begin(), std::next(pose));
    waiting_.pop_front();
  }
}

void SessionColumns::Write(const Waiting& answer, double pose_s) {
  const wire::Wrench& w = answer.wrench;
  ColumnFile& t = wrenches_;
  t.Add("time_s", answer.time_s);
  t.Add("pose_sequence", std::uint64_t{w.pose_sequence});
  t.Add("answer", std::uint32_t{w.answer});
  t.Add("age_s", answer.time_s - pose_s);
  t.Add("step_time_s", w.step_time_s);
  t.Add("step", std::uint64_t{w.step});
  t.Add("hands", std::uint32_t{w.hands});
  t.AddVector("force", "N", w.force_N);
  t.AddVector("torque", "Nm", w.torque_Nm);
  t.AddVector("passive_force", "N", w.passive_force_N);
  t.AddVector("passive_torque", "Nm", w.passive_torque_Nm);
  t.AddVector("active_force", "N", w.active_force_N);
  t.AddVector("active_torque", "Nm", w.active_torque_Nm);
  t.AddPose("tool", w.graphic_position_m, w.graphic_orientation_wxyz);
  t.Add("contacts", std::uint32_t{w.contacts});
  t.Add("rows", std::uint32_t{w.rows});
  static constexpr const char* kRows[] = {"row_0_force_N", "row_1_force_N", "row_2_force_N",
                                          "row_3_force_N", "row_4_force_N", "row_5_force_N"};
  for (std::size_t i = 0; i < std::size(kRows); ++i) t.Add(kRows[i], w.row_force_N[i]);
  t.Add("region_m", w.region_m);
  t.Add("region_rad", w.region_rad);
  t.Add("valid_s", w.valid_s);
  t.Add("faults", std::uint32_t{w.faults});
  t.EndRow();

  if (w.faults == faults_before_) return;
  faults_before_ = w.faults;
  faults_.Add("time_s", answer.time_s);
  faults_.Add("pose_sequence", std::uint64_t{w.pose_sequence});
  faults_.Add("faults", std::uint32_t{w.faults});
  faults_.Add("words", FaultWords(w.faults), kTextWidth);
  faults_.EndRow();
}

void SessionColumns::Add(const wire::ToolState& tool, double time_s) {
  ColumnFile& t = tool_states_;
  t.Add("time_s", time_s);
  t.Add("pose_sequence", std::uint64_t{tool.pose_sequence});
  t.AddPose("hand", tool.haptic_position_m, tool.haptic_orientation_wxyz);
  t.AddPose("tool", tool.graphic_position_m, tool.graphic_orientation_wxyz);
  t.AddVector("force", "N", tool.force_N);
  t.AddVector("torque", "Nm", tool.torque_Nm);
  t.Add("step_time_s", 1e-6 * tool.step_us);
  t.Add("contacts", std::uint32_t{tool.contacts});
  t.Add("points", std::uint32_t{tool.points});
  t.Add("faults", std::uint32_t{tool.faults});
  t.EndRow();

  const std::size_t points = std::min<std::size_t>(tool.points, std::size(tool.point));
  for (std::size_t i = 0; i < points; ++i) {
    contacts_.Add("time_s", time_s);
    contacts_.Add("pose_sequence", std::uint64_t{tool.pose_sequence});
    contacts_.AddVector("point", "m", tool.point[i].position_m);
    contacts_.AddVector("force", "N", tool.point[i].force_N);
    contacts_.EndRow();
  }
}

void SessionColumns::Add(const wire::SessionState& state, double time_s) {
  ColumnFile& t = phases_;
  t.Add("time_s", time_s);
  t.Add("phase", PhaseName(state.phase), kWordWidth);
  t.Add("scene", Printable(state.scene), kNameWidth);
  t.Add("tool", Printable(state.tool), kNameWidth);
  t.Add("stiffness_N_per_m", state.stiffness_N_per_m);
  t.Add("torsional_stiffness_Nm_per_rad", state.torsional_stiffness_Nm_per_rad);
  t.AddVector("tool_reference", "m", state.tool_reference_m);
  t.Add("start_sequence", std::uint64_t{state.start_sequence});
  t.AddPose("start", state.start_position_m, state.start_orientation_wxyz);
  t.Add("start_depth_m", state.start_depth_m);
  t.Add("muted", std::uint32_t{state.muted});
  t.Add("reason", Printable(state.reason), kTextWidth);
  t.EndRow();
}

void SessionColumns::Add(const wire::LoopStatistics& loop, double time_s) {
  ColumnFile& t = loop_;
  t.Add("time_s", time_s);
  t.Add("period_s", loop.period_s);
  t.Add("steps", std::uint64_t{loop.steps});
  t.Add("rate_Hz", loop.rate_hz);
  t.Add("step_time_p50_s", 1e-6 * loop.step_us_p50);
  t.Add("step_time_p99_s", 1e-6 * loop.step_us_p99);
  t.Add("step_time_p999_s", 1e-6 * loop.step_us_p999);
  t.Add("step_time_max_s", 1e-6 * loop.step_us_max);
  t.Add("late", std::uint64_t{loop.late});
  t.Add("lost", std::uint64_t{loop.lost});
  t.Add("rejected_nonfinite", std::uint64_t{loop.rejected_nonfinite});
  t.Add("rejected_sequence", std::uint64_t{loop.rejected_sequence});
  t.Add("rejected_speed", std::uint64_t{loop.rejected_speed});
  t.Add("renormalised", std::uint64_t{loop.renormalised});
  t.Add("faulted_steps", std::uint64_t{loop.faulted_steps});
  t.Add("contacts", std::uint32_t{loop.contacts});
  t.Add("faults", std::uint32_t{loop.faults});
  t.EndRow();
}

void SessionColumns::Add(const wire::StationStatistics& s, double time_s) {
  ColumnFile& t = limiter_;
  t.Add("time_s", time_s);
  t.Add("period_s", s.period_s);
  t.Add("ticks", std::uint64_t{s.ticks});
  t.Add("missed_ticks", std::uint64_t{s.missed_ticks});
  t.Add("sent", std::uint64_t{s.sent});
  t.Add("replies", std::uint64_t{s.replies});
  t.Add("late", std::uint64_t{s.late});
  t.Add("lost", std::uint64_t{s.lost});
  t.Add("silence_max_s", s.silence_s_max);
  t.Add("nonfinite", std::uint64_t{s.nonfinite});
  t.Add("clamped", std::uint64_t{s.clamped});
  t.Add("slewed", std::uint64_t{s.slewed});
  t.Add("braked", std::uint64_t{s.braked});
  t.Add("warm", std::uint64_t{s.warm});
  t.Add("faded", std::uint64_t{s.faded});
  t.Add("fades", std::uint64_t{s.fades});
  t.Add("disabled", std::uint64_t{s.disabled});
  t.Add("wanted_force_max_N", s.wanted_force_N_max);
  t.Add("wanted_torque_max_Nm", s.wanted_torque_Nm_max);
  t.Add("applied_force_max_N", s.applied_force_N_max);
  t.Add("applied_torque_max_Nm", s.applied_torque_Nm_max);
  t.Add("energy_J", s.energy_J);
  t.Add("energy_min_J", s.energy_J_min);
  t.Add("warmth", s.warmth);
  t.Add("device_status", std::uint32_t{s.device_status});
  t.EndRow();
}

void SessionColumns::Add(const wire::GuideTarget& guide, double time_s) {
  guide_.Add("time_s", time_s);
  guide_.Add("number", std::uint64_t{guide.number});
  guide_.AddPose("aim", guide.position_m, guide.orientation_wxyz);
  guide_.EndRow();
}

std::size_t SessionColumns::pending() {
  std::size_t sum = 0;
  for (const ColumnFile* table : tables()) {
    sum += table->pending();
  }
  return sum;
}

void SessionColumns::Flush() {
  for (ColumnFile* table : tables()) table->Flush();
}

void SessionColumns::Close() {
  WriteAnswered(true);
  for (ColumnFile* table : tables()) table->Close();
}

std::vector<std::string> SessionColumns::files() {
  std::vector<std::string> files;
  for (const ColumnFile* table : tables()) {
    if (table->rows() > 0) files.push_back(table->file());
  }
  return files;
}

}  // namespace palpate
