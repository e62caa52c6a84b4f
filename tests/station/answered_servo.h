#pragma once

#include <functional>
#include <utility>

#include "client/station/servo_thread.h"
#include "common/realtime/steady_clock.h"
#include "tests/support/eventually.h"

namespace palpate::test {

/// A device with its servo thread, whose poses go nowhere; the test plays the server.
template <class Device>
struct AnsweredServo {
  template <class... Arguments>
  explicit AnsweredServo(Arguments&&... arguments)
      : device(std::forward<Arguments>(arguments)...) {}

  /// Answers poses with 2 N upwards until `so`.
  bool AnswerUntil(const std::function<bool()>& so) {
    return Eventually([&] {
      device.Attend();
      while (servo.ReadSnapshot(snapshot)) {
      }
      if (so()) return true;
      Reply reply;
      reply.pose_sequence = snapshot.sent;
      reply.pose_time_ns = servo.sample_time_ns(reply.pose_sequence);
      reply.received_ns = SteadyNanoseconds();
      reply.wrench.force = Vec3(0, 2.0, 0);
      replies.Push(reply);
      return false;
    });
  }

  Device device;
  StationCore core{device};
  ReplyRing replies;
  ServoThread servo{core, replies, 0.002};  // each snapshot allows one fresh reply
  PosePath path;
  StationSnapshot snapshot;
};

}  // namespace palpate::test
