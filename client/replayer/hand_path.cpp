#include "client/replayer/hand_path.h"

#include <algorithm>
#include <map>
#include <optional>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"

namespace palpate {
namespace {

struct Session {
  std::string station, scene;
  std::uint64_t poses = 0;
};
struct HandSample {
  std::uint64_t sequence;
  std::int64_t time_ns;
  Pose X_WH;
  Pose X_WG;
  Wrench wrench{};

  void Answer(const wire::Wrench& answer) {
    wrench = wire::ToWrench(answer);
    X_WG = wire::ToPose(answer.graphic_position_m, answer.graphic_orientation_wxyz);
  }
};

/// A topic of poses or wrenches without its last part: the same for both of a session.
std::string SessionOf(const std::string& topic) {
  return topic.substr(0, topic.rfind('/'));
}

std::optional<Pose> UsablePose(const wire::HapticPose& pose) {
  Pose X_WH = wire::ToPose(pose);
  if (!X_WH.p.allFinite() || !X_WH.q.coeffs().allFinite() || !(X_WH.q.squaredNorm() > 0.25)) {
    return std::nullopt;
  }
  X_WH.q.normalize();
  return X_WH;
}

}  // namespace

HandPath ReadHandPath(const std::vector<std::string>& files) {
  RecordingReader reader(files);
  RecordedSample sample{};
  std::map<std::string, Session> sessions;
  while (reader.Next(sample)) {
    wire::SessionState state{};
    if (sample.type == RecordedType::kHapticPose) {
      ++sessions[SessionOf(*sample.topic)].poses;
    } else if (sample.To(state)) {
      Session& session = sessions[SessionOf(dds::PoseTopic(state.station, state.run))];
      session.station = state.station;
      session.scene = state.scene;
    }
  }
  const auto longest =
      std::ranges::max_element(sessions, {}, [](const auto& entry) { return entry.second.poses; });

  // A second time, because whole sessions of a class do not fit into memory.
  std::vector<HandSample> hand;
  const auto find = [&](std::uint64_t sequence) {
    return std::ranges::lower_bound(hand, sequence, {}, &HandSample::sequence);
  };
  std::vector<wire::Wrench> early;  // wrenches that overtook their poses
  reader.Restart();
  while (longest != sessions.end() && reader.Next(sample)) {
    wire::HapticPose pose;
    wire::Wrench wrench;
    if (SessionOf(*sample.topic) != longest->first) continue;
    if (sample.To(pose)) {
      const auto X_WH = UsablePose(pose);
      // In their order, each once.
      if (X_WH && (hand.empty() || pose.pose_sequence > hand.back().sequence)) {
        hand.push_back({pose.pose_sequence, pose.sample_time_ns, *X_WH, *X_WH});
      }
    } else if (sample.To(wrench)) {
      const auto at = find(wrench.pose_sequence);
      if (at != hand.end() && at->sequence == wrench.pose_sequence) {
        at->Answer(wrench);
      } else {
        early.push_back(wrench);
      }
    }
  }
  for (const wire::Wrench& wrench : early) {
    const auto at = find(wrench.pose_sequence);
    if (at != hand.end() && at->sequence == wrench.pose_sequence) at->Answer(wrench);
  }
  if (hand.size() < 2) {
    throw Error(files.front() + ": holds no hand's path; record it without --no-loop");
  }
  HandPath path;
  path.station = longest->second.station;
  path.scene = longest->second.scene;
  for (const HandSample& at : hand) {
    path.time_s.push_back(1e-9 * static_cast<double>(at.time_ns - hand.front().time_ns));
    path.X_WH.push_back(at.X_WH);
    path.X_WG.push_back(at.X_WG);
    path.force_N.push_back(at.wrench.force);
    path.torque_Nm.push_back(at.wrench.torque);
  }
  return path;
}

}  // namespace palpate
