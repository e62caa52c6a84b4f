#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "common/program/child_program.h"

namespace palpate {

/// Returns the pose as an input line of a station's mouse device (devices/mouse/mouse_device.h),
/// exact to the bit.
/// @param still  a bur stands still there
std::string ToMouseLine(const Pose& X_WT, bool still = false);

/// A palpate-station with the mouse device, run as a child process; its hand follows Drag.
/// The server treats it as any other station.  It ends when its input ends, also if this
/// process is killed.
/// Thread contract: one thread.  Nothing blocks except the destructor, which kills the child.
class MouseStation {
 public:
  /// @param program  path of palpate-station.   @param arguments  without the program's name.
  /// Throws Error if no process can be created.
  MouseStation(const std::string& program, const std::vector<std::string>& arguments);
  /// Sends a pose.  Only the newest counts; one that the busy child has not read is skipped.
  void Drag(const Pose& X_WT, bool still = false) { child_.Write(ToMouseLine(X_WT, still)); }
  /// Lets its hand rest at the tool's present pose, without force, until the next pose.
  void Rest() { child_.Write("release\n"); }
  /// Closes its input; it leaves its session and ends within a second, or is killed after three.
  void LetGo(std::int64_t now_ns);

  /// To be called some 100 times a second.  Returns false once it has ended.
  bool Poll(std::int64_t now_ns);
  /// Its last complaint, once it has ended; empty: it ended in order.
  const std::string& complaint() const { return child_.complaint(); }

 private:
  ChildProgram child_;
  std::int64_t let_go_ns_ = 0;
};

}  // namespace palpate
