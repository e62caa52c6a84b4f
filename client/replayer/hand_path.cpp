#include "client/replayer/hand_path.h"

#include <map>
#include <utility>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"

namespace palpate {
namespace {

struct Session {
  std::string station, scene;
  std::map<std::uint64_t, wire::HapticPose> poses;
  std::map<std::uint64_t, std::pair<Vec3, Vec3>> wrenches;
};

}  // namespace

HandPath ReadHandPath(const std::vector<std::string>& files) {
  RecordingReader reader(files);
  std::map<std::string, Session> sessions;        // by topic of poses
  std::map<std::string, std::string> pose_topic;  // by topic of wrenches
  RecordedSample sample{};
  const auto end = [](const std::string& topic) { return topic.substr(0, topic.rfind('/')); };
  while (reader.Next(sample)) {
    wire::HapticPose pose;
    wire::Wrench wrench;
    wire::SessionState state{};
    if (sample.To(pose)) {
      sessions[end(*sample.topic)].poses.emplace(pose.pose_sequence, pose);
    } else if (sample.To(wrench)) {
      const palpate::Wrench w = wire::ToWrench(wrench);
      sessions[end(*sample.topic)].wrenches.emplace(wrench.pose_sequence,
                                                    std::pair(w.force, w.torque));
    } else if (sample.To(state)) {
      Session& session = sessions[end(dds::PoseTopic(state.station, state.run))];
      session.station = state.station;
      session.scene = state.scene;
    }
  }
  const Session* longest = nullptr;
  for (const auto& [topic, session] : sessions) {
    if (!longest || session.poses.size() > longest->poses.size()) longest = &session;
  }
  if (!longest || longest->poses.size() < 2) {
    throw Error(files.front() + ": holds no hand's path; record it without --no-loop");
  }
  HandPath path;
  path.station = longest->station;
  path.scene = longest->scene;
  const std::int64_t began_ns = longest->poses.begin()->second.sample_time_ns;
  for (const auto& [sequence, pose] : longest->poses) {
    const Pose X_WH = wire::ToPose(pose);
    if (!X_WH.p.allFinite() || !(X_WH.q.squaredNorm() > 0.25)) continue;
    path.time_s.push_back(1e-9 * static_cast<double>(pose.sample_time_ns - began_ns));
    path.X_WH.push_back({X_WH.p, X_WH.q.normalized()});
    const auto wrench = longest->wrenches.find(sequence);
    const bool has = wrench != longest->wrenches.end();
    path.force_N.push_back(has ? wrench->second.first : Vec3::Zero());
    path.torque_Nm.push_back(has ? wrench->second.second : Vec3::Zero());
  }
  return path;
}

}  // namespace palpate
