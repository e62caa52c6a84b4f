#pragma once

#include <termios.h>

namespace palpate {

/// Single keys from the terminal on standard input, without Enter; silent where that is none.
class Keyboard {
 public:
  enum class Key {
    kNone,
    kSpace,
    kLeft,
    kRight,
    kNext,
    kPrevious,
    kFaster,
    kSlower,
    kBookmark,
    kQuit
  };

  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  bool is_terminal() const { return terminal_; }
  /// The next key that was pressed; never waits.
  Key Read();

 private:
  bool terminal_ = false;
  termios former_{};
};

}  // namespace palpate
