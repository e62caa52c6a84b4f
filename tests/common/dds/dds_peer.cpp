// The other process of the DDS tests: writes HapticPose samples on one loop topic.
//   dds_peer TRANSPORT DOMAIN TOPIC COUNT matched|at-once|matched-in-step|in-step
// Once a millisecond; in step, each sample when a byte comes in, and a '.' goes out when it is
// written: so a test sees every sample, however busy the machine is.  `matched` waits for a reader.
// Sample i (from 1) carries i in every field that holds a number.  Or writes one SceneBundle of
// BYTES bytes on a topic of the service domain, byte i holding i, and stays until it is killed.
//   dds_peer bundle DOMAIN TOPIC BYTES at-once
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

int main(int argc, char** argv) {
  using namespace palpate;
  using std::chrono::milliseconds;
  if (argc != 6) return 2;
  if (std::string(argv[1]) == "bundle") {
    const dds::Participant service = dds::Participant::Service(std::atoi(argv[2]));
    dds::Writer<wire::SceneBundle> writer(service, argv[3], dds::Qos::kSession);
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::atoll(argv[4])));
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    wire::SceneBundle sample{};
    wire::FromText("peer", sample.scene);
    sample.hash = bytes.size();
    sample.bundle._buffer = bytes.data();
    sample.bundle._length = sample.bundle._maximum = static_cast<std::uint32_t>(bytes.size());
    if (!writer.Write(sample)) return 1;
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  const dds::TransportChoice choice{dds::ParseTransport(argv[1]), ""};
  const dds::Participant participant = dds::Participant::Loop(std::atoi(argv[2]), choice);
  dds::Writer<wire::HapticPose> writer(participant, argv[3], dds::Qos::kLoop);
  const std::string start = argv[5];
  const bool in_step = start.ends_with("in-step");
  if (start.starts_with("matched")) {
    for (int i = 0; i < 10'000 && writer.matched_readers() == 0; ++i) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    std::this_thread::sleep_for(milliseconds(100));
  }
  for (int i = 1; i <= std::atoi(argv[4]); ++i) {
    char go = 0;
    if (in_step && read(STDIN_FILENO, &go, 1) != 1) break;
    wire::HapticPose pose{};
    pose.pose_sequence = i;
    pose.sample_time_ns = i;
    for (double& x : pose.position_m) x = i;
    for (double& x : pose.orientation_wxyz) x = i;
    pose.device_status = i;
    if (!writer.Write(pose)) return 1;
    if (in_step) {
      if (write(STDOUT_FILENO, ".", 1) != 1) return 1;
    } else {
      std::this_thread::sleep_for(milliseconds(1));
    }
  }
  std::this_thread::sleep_for(milliseconds(100));  // a reader may still take
  return 0;
}
