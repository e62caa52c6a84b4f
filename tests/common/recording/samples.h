#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/dds/cdr.h"
#include "common/dds/topics.h"
#include "common/files/bundle_hash.h"
#include "common/recording/recording_writer.h"
#include "tests/support/folder.h"

namespace palpate::test {

/// Sets every double from `begin` on to a value of its own.
template <std::size_t N>
void Number(double (&field)[N], double begin) {
  for (std::size_t i = 0; i < N; ++i) field[i] = begin + static_cast<double>(i);
}

inline wire::HapticPose SamplePose(std::uint64_t sequence) {
  wire::HapticPose pose{};
  pose.pose_sequence = sequence;
  pose.sample_time_ns = static_cast<std::int64_t>(1'000'000 * sequence);
  Number(pose.position_m, 0.125 * static_cast<double>(sequence));
  Number(pose.orientation_wxyz, 10.5);
  Number(pose.linear_velocity_m_s, 20.5);
  Number(pose.angular_velocity_rad_s, 30.5);
  pose.buttons = 5;
  pose.device_status = 6;
  return pose;
}

inline wire::Wrench SampleWrench(std::uint64_t sequence) {
  wire::Wrench wrench{};
  wrench.pose_sequence = sequence;
  wrench.pose_time_ns = static_cast<std::int64_t>(1'000'000 * sequence);
  Number(wrench.force_N, 0.125 * static_cast<double>(sequence));
  Number(wrench.torque_Nm, 10.5);
  Number(wrench.graphic_position_m, 20.5);
  Number(wrench.graphic_orientation_wxyz, 30.5);
  for (int i = 0; i < 6; ++i) Number(wrench.row[i], 100.25 + 10 * i);
  Number(wrench.row_offset_m, 200.5);
  Number(wrench.row_force_N, 300.5);
  wrench.region_m = 1.5;
  wrench.region_rad = 2.5;
  wrench.valid_s = 3.5;
  wrench.step_time_s = 4.5;
  wrench.rows = 7;
  wrench.contacts = 8;
  wrench.faults = 9;
  wrench.answer = static_cast<std::uint32_t>(sequence);
  return wrench;
}

inline wire::SessionState SampleState(const std::string& station, std::uint64_t run) {
  wire::SessionState state{};
  wire::FromText(station, state.station);
  state.run = run;
  state.server_run = 77;
  state.phase = palpate_SESSION_ACTIVE;
  wire::FromText("cube", state.scene);
  wire::FromText("ball", state.tool);
  wire::FromText("as a test wants it", state.reason);
  state.start_sequence = 3;
  Number(state.start_position_m, 0.5);
  Number(state.start_orientation_wxyz, 4.5);
  return state;
}

/// Each number is another block of the same solid.
inline wire::SolidBlock SampleBlock(std::uint64_t number) {
  wire::SolidBlock block{};
  wire::FromText("cube", block.scene);
  block.block = static_cast<std::uint32_t>(number);
  block.change = number;
  block.server_run = 77;
  return block;
}

template <class T>
void Add(RecordingWriter& writer, const std::string& topic, const T& sample, std::int64_t time_ns) {
  std::vector<std::uint8_t> cdr;
  dds::ToCdr(sample, cdr);
  writer.Add(topic, kTypeOf<T>, time_ns, cdr);
}

/// `bytes` must outlive the sample.
inline wire::SceneBundle SampleBundle(std::vector<std::uint8_t>& bytes,
                                      const std::string& scene = "cube",
                                      std::uint64_t server_run = 77) {
  wire::SceneBundle bundle{};
  wire::FromText(scene, bundle.scene);
  bundle.server_run = server_run;
  bundle.hash = BundleHash(bytes);
  bundle.bundle._buffer = bytes.data();
  bundle.bundle._length = bundle.bundle._maximum = static_cast<std::uint32_t>(bytes.size());
  return bundle;
}

/// @param forged  gives it the hash of other bytes.
inline void AddBundle(RecordingWriter& writer, std::vector<std::uint8_t> bytes,
                      std::int64_t time_ns, bool forged = false) {
  wire::SceneBundle bundle = SampleBundle(bytes);
  bundle.hash ^= forged ? 1 : 0;
  Add(writer, dds::kSceneBundleTopic, bundle, time_ns);
}

}  // namespace palpate::test
