// The other process of the DDS tests: writes HapticPose samples on one loop topic, once a
// millisecond.
//   dds_peer TRANSPORT DOMAIN TOPIC COUNT matched|at-once
// Sample i (from 1) carries i in every field that holds a number.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

int main(int argc, char** argv) {
  using namespace palpate;
  using std::chrono::milliseconds;
  if (argc != 6) return 2;
  const dds::TransportChoice choice{dds::ParseTransport(argv[1]), ""};
  const dds::Participant participant = dds::Participant::Loop(std::atoi(argv[2]), choice);
  dds::Writer<wire::HapticPose> writer(participant, argv[3], dds::Qos::kLoop);
  if (std::string(argv[5]) == "matched") {
    for (int i = 0; i < 10'000 && writer.matched_readers() == 0; ++i) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    std::this_thread::sleep_for(milliseconds(100));
  }
  for (int i = 1; i <= std::atoi(argv[4]); ++i) {
    wire::HapticPose pose{};
    pose.pose_sequence = i;
    pose.sample_time_ns = i;
    for (double& x : pose.position_m) x = i;
    for (double& x : pose.orientation_wxyz) x = i;
    pose.device_status = i;
    if (!writer.Write(pose)) return 1;
    std::this_thread::sleep_for(milliseconds(1));
  }
  std::this_thread::sleep_for(milliseconds(100));  // a reader may still be taking
  return 0;
}
