#pragma once

#include <termios.h>

#include "client/replayer/playback.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Reads single keys from the terminal on standard input, without Enter; returns none if standard
/// input is no terminal.
class Keyboard {
 public:
  /// A key is its character, or one of these.
  enum : int { kNone = -1, kLeft = 256, kRight };

  /// Help text for the keys.
  static constexpr const char* kHelp =
      R"(Keys:  space pauses, resumes    <- 5 s back    -> 5 s forward; paused: a step
       p, n previous, next mark    -, + slower, faster    b bookmark    q quits)";

  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// Returns the next key that was pressed, or kNone; never blocks.
  int Read();

 private:
  bool terminal_ = false;
  termios former_{};
};

struct PlayOptions {
  bool stepping = false;  ///< begins paused
  bool locked = false;    ///< viewers may not steer
  bool stays = false;     ///< waits at the end
};

/// Publishes a recording's service topics to viewers as a server would, at the recorded pace, until
/// its end, a signal or `q`.  Does not publish poses and wrenches.  Throws Error if a server runs
/// in the domain, or nothing in the recording is for viewers.
void Play(const Playback& playback, const PlayOptions& options, StopSignal& stop);

}  // namespace palpate
