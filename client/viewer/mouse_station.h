#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "common/program/child_program.h"

namespace palpate {

/// The pose as a line for a station's mouse device (devices/mouse/mouse_device.h), to the bit.
std::string ToMouseLine(const Pose& X_WT);

/// A palpate-station with the mouse device, run as a child: its hand follows what Drag says.  It is
/// a station like any other, so the server's rules for sessions are its rules.  Ends by itself
/// where its input does, also when this process is killed. Thread contract: one thread.  Nothing
/// here blocks, but for the destructor: it kills.
class MouseStation {
 public:
  /// @param program  path of palpate-station.   @param arguments  without the program's name.
  /// Throws Error where no process can be made.
  MouseStation(const std::string& program, const std::vector<std::string>& arguments);
  /// The newest pose counts: one that the child is too busy to read is passed over.
  void Drag(const Pose& X_WT) { child_.Write(ToMouseLine(X_WT)); }
  /// Ends its input; it leaves its session and ends within a second, or is killed after three.
  void LetGo(std::int64_t now_ns);

  /// Looks after it, some 100 times a second.  False once it has ended.
  bool Poll(std::int64_t now_ns);
  /// Once it has ended: what it complained of last; empty where it ended in order.
  const std::string& complaint() const { return child_.complaint(); }

 private:
  ChildProgram child_;
  std::int64_t let_go_ns_ = 0;
};

}  // namespace palpate
