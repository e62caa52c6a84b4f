#include "client/replayer/hand_path.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "client/replayer/playback.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"
#include "common/text/hex16.h"

namespace palpate {
namespace {

/// The tremor of a hand at rest is smaller; this angle moves a tip 57 mm away by as much.
constexpr double kMoved_m = 1e-3, kTurned_rad = std::numbers::pi / 180.0;
/// Bounds of a plausible measurement: no arm reaches further or presses harder.
constexpr double kFarthest_m = 1e3, kHardest_N = 1e6, kHardest_Nm = 1e6;
constexpr double kLongestPause_s = 86'400.0;  // no trial is interrupted for a day
/// Longer lists are left to palpate-record info.
constexpr std::size_t kMostListed = 20;

struct Session {
  std::string station, scene, tool;
  std::uint64_t run = 0, poses = 0;
  std::int64_t first_ns = 0, last_ns = 0;  // of its poses
};
using SessionKey = std::pair<std::string, std::uint64_t>;  // station, run

struct HandSample {
  std::uint64_t sequence;
  std::int64_t time_ns;
  Pose X_WH;
  std::optional<Pose> X_WG{};  // none: it was not answered
  Wrench wrench{};
};

std::optional<Pose> Usable(Pose X) {
  if (!(X.p.norm() < kFarthest_m) || !X.q.coeffs().allFinite() || !(X.q.squaredNorm() > 0.25)) {
    return std::nullopt;
  }
  X.q.normalize();
  return X;
}

void Answer(HandSample& at, const wire::Wrench& answer) {
  const Wrench wrench = wire::ToWrench(answer);
  if (!(wrench.force.norm() < kHardest_N) || !(wrench.torque.norm() < kHardest_Nm)) return;
  at.X_WG = Usable(wire::ToPose(answer.graphic_position_m, answer.graphic_orientation_wxyz));
  if (at.X_WG) at.wrench = wrench;
}

/// Returns whether a pose follows the last one in sequence and time.  A jump is rejected too, since
/// it would shut out all later poses.
bool GoesOn(const HandSample& last, const wire::HapticPose& pose) {
  const double after_s = SecondsBetween(last.time_ns, pose.sample_time_ns);
  return pose.pose_sequence > last.sequence &&
         pose.pose_sequence - last.sequence <= SequenceCount::kMostHole && after_s > 0.0 &&
         after_s < kLongestPause_s;
}

/// Returns the sessions that have poses, by their beginning.
/// @param began_ns  receives the time of the recording's first sample.
std::vector<Session> SessionsOf(RecordingReader& reader, std::int64_t& began_ns) {
  std::map<SessionKey, Session> sessions;
  RecordedSample sample{};
  for (bool any = false; reader.Next(sample); any = true) {
    if (!any) began_ns = sample.log_time_ns;
    wire::SessionState state{};
    if (sample.type == RecordedType::kHapticPose) {
      const auto key = dds::SessionOfTopic(*sample.topic);
      if (!key) continue;
      Session& session = sessions[*key];
      if (session.poses++ == 0) session.first_ns = session.last_ns = sample.log_time_ns;
      session.last_ns = std::max(session.last_ns, sample.log_time_ns);
    } else if (sample.To(state)) {
      Session& session = sessions[{state.station, state.run}];
      session.scene = state.scene;
      session.tool = state.tool;
    }
  }
  std::vector<Session> found;
  for (auto& [key, session] : sessions) {
    if (session.poses == 0) continue;
    std::tie(session.station, session.run) = key;
    found.push_back(std::move(session));
  }
  std::ranges::stable_sort(found, {}, &Session::first_ns);
  return found;
}

Session Choose(const std::string& file, const std::vector<Session>& sessions, std::int64_t began_ns,
               const SessionChoice& choice) {
  const auto with_run = [](const Session& s) { return s.station + "/" + Hex16(s.run); };
  const auto fits = [&](const Session& s) {
    return choice.wanted.empty() || choice.wanted == s.station || choice.wanted == with_run(s);
  };
  if (sessions.empty()) {
    throw Error(file + ": has no poses of a hand; record it without --no-loop");
  }
  const auto first = std::ranges::find_if(sessions, fits);
  if (first != sessions.end() && std::none_of(first + 1, sessions.end(), fits)) return *first;

  std::string list;
  std::size_t listed = 0;
  for (const Session& s : sessions) {
    // If none fits, lists all.
    if (first != sessions.end() && !fits(s)) continue;
    if (++listed > kMostListed) continue;
    const bool is_only = std::ranges::count(sessions, s.station, &Session::station) == 1;
    list += fmt::format("{}{} {} (tool {}, from {:.1f} s, {:.1f} s long)", list.empty() ? "" : ", ",
                        choice.option, is_only ? s.station : with_run(s),
                        s.tool.empty() ? "not known" : s.tool, SecondsBetween(began_ns, s.first_ns),
                        SecondsBetween(s.first_ns, s.last_ns));
  }
  if (listed > kMostListed) list += fmt::format(" and {} more", listed - kMostListed);
  throw Error(file + ": holds " +
              (first == sessions.end()
                   ? fmt::format("no session of station '{}'; give one of these: ", choice.wanted)
                   : fmt::format("{} sessions; choose one: ", listed)) +
              list);
}

/// Reads the poses of a session with their answers, in a second pass: all sessions of a class do
/// not fit into memory.   @param cuts  set if the recording holds data about cut solids.
std::vector<HandSample> SamplesOf(RecordingReader& reader, const Session& session, bool& cuts) {
  const std::string poses = dds::PoseTopic(session.station, session.run);
  const std::string wrenches = dds::WrenchTopic(session.station, session.run);
  std::vector<HandSample> hand;
  std::vector<wire::Wrench> early;  // wrenches that came before their poses
  const auto take = [&](const wire::Wrench& wrench) {
    const auto at = std::ranges::lower_bound(hand, wrench.pose_sequence, {}, &HandSample::sequence);
    const bool is_there = at != hand.end() && at->sequence == wrench.pose_sequence;
    if (is_there) Answer(*at, wrench);
    return is_there;
  };
  RecordedSample sample{};
  reader.Restart();
  while (reader.Next(sample)) {
    cuts = cuts || sample.type == RecordedType::kSolidBlock;
    wire::HapticPose pose;
    wire::Wrench wrench;
    if (*sample.topic == poses && sample.To(pose)) {
      const auto X_WH = Usable(wire::ToPose(pose));
      if (X_WH && (hand.empty() || GoesOn(hand.back(), pose))) {
        hand.push_back({pose.pose_sequence, pose.sample_time_ns, *X_WH});
      }
    } else if (*sample.topic == wrenches && sample.To(wrench)) {
      if (!take(wrench)) early.push_back(wrench);
    }
  }
  for (const wire::Wrench& wrench : early) take(wrench);
  return hand;
}

/// Returns the sessions of the only station, if they drive one tool of one scene; else none.
std::vector<Session> OfOneStation(const std::vector<Session>& sessions,
                                  const SessionChoice& choice) {
  std::vector<Session> found;
  for (const Session& session : sessions) {
    if (choice.wanted.empty() || choice.wanted == session.station) found.push_back(session);
  }
  const auto whose = [](const Session& s) { return std::tie(s.station, s.scene, s.tool); };
  const bool is_one = std::ranges::all_of(
      found, [&](const Session& session) { return whose(session) == whose(found.front()); });
  return is_one ? found : std::vector<Session>();
}

}  // namespace

HandPath ReadHandPath(const std::vector<std::string>& files, const SessionChoice& choice) {
  RecordingReader reader(files);
  std::int64_t began_ns = 0;
  const std::vector<Session> sessions = SessionsOf(reader, began_ns);
  std::vector<Session> chosen;
  if (choice.joins) chosen = OfOneStation(sessions, choice);
  if (chosen.empty()) chosen = {Choose(files.front(), sessions, began_ns, choice)};

  HandPath path;
  std::vector<HandSample> hand;
  for (const Session& session : chosen) {
    for (HandSample& at : SamplesOf(reader, session, path.cuts)) {
      // A station keeps its clock when it connects again.
      if (hand.empty() || at.time_ns > hand.back().time_ns) hand.push_back(std::move(at));
    }
  }
  if (hand.size() < 2) {
    throw Error(files.front() + ": has no poses of a hand; record it without --no-loop");
  }
  path.station = chosen.back().station;
  path.run = chosen.back().run;
  path.begun_ns = chosen.front().first_ns;
  path.scene = chosen.back().scene;
  path.tool_name = chosen.back().tool;
  path.sessions = static_cast<int>(chosen.size());
  for (const HandSample& at : hand) {
    path.time_s.push_back(SecondsBetween(hand.front().time_ns, at.time_ns));
    path.X_WH.push_back(at.X_WH);
    path.X_WG.push_back(at.X_WG.value_or(at.X_WH));
    path.answered.push_back(at.X_WG.has_value());
    path.force_N.push_back(at.wrench.force);
    path.torque_Nm.push_back(at.wrench.torque);
  }
  if (std::ranges::count(path.answered, true) == 0) path.X_WG.clear();
  path.cut_off = !reader.complete();
  return path;
}

HandPath TrialIn(const HandPath& path, const std::string& file) {
  // If nothing is answered, the hand's motion is all that there is.
  const bool any = std::ranges::count(path.answered, true) > 0;
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!any || path.answered[i]) known.push_back(i);
  }
  const auto is_away = [&](std::size_t i, std::size_t from) {
    const Pose &X = path.X_WH[i], &Y = path.X_WH[from];
    return (X.p - Y.p).norm() > kMoved_m || X.q.angularDistance(Y.q) > kTurned_rad;
  };
  const auto moves_off = [&](std::size_t i) {
    return i + 1 < known.size() && is_away(known[i + 1], known.front());
  };
  const auto arrives = [&](std::size_t i) { return i > 0 && is_away(known[i - 1], known.back()); };
  std::size_t begin = 0, end = known.size();
  while (begin < end && !path.touches(known[begin]) && !moves_off(begin)) ++begin;
  while (end > begin && !path.touches(known[end - 1]) && !arrives(end - 1)) --end;
  if (end - begin < 2) {
    throw Error(file +
                ": the hand neither moves more than 1 mm or 1 degree nor touches anything; give a "
                "recording of a trial");
  }
  const auto part = [&](const auto& all) {
    std::remove_cvref_t<decltype(all)> of;
    for (std::size_t i = begin; i < end && !all.empty(); ++i) of.push_back(all[known[i]]);
    return of;
  };
  HandPath trial{path.station,         path.scene,      path.run,        path.cuts,
                 part(path.time_s),    part(path.X_WH), part(path.X_WG), part(path.force_N),
                 part(path.torque_Nm), path.tool_name,  path.sessions};
  for (double& t : trial.time_s) t -= path.time_s[known[begin]];
  if (!path.answered.empty()) {
    // A hand that goes on after the last answer is on trial still.
    const std::size_t last =
        is_away(path.size() - 1, known.back()) ? path.size() - 1 : known[end - 1];
    const auto poses = static_cast<double>(last - known[begin] + 1);
    trial.unanswered_share = any ? 1.0 - static_cast<double>(trial.size()) / poses : 1.0;
  }
  trial.cut_off = path.cut_off;
  trial.begun_ns = path.begun_ns;
  return trial;
}

}  // namespace palpate
