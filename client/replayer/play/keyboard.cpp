#include "client/replayer/play/keyboard.h"

#include <poll.h>
#include <unistd.h>

namespace palpate {
namespace {

/// The next byte; -1 where none has come.
int NextByte() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  unsigned char byte = 0;
  return poll(&input, 1, 0) == 1 && read(STDIN_FILENO, &byte, 1) == 1 ? byte : -1;
}

Keyboard::Key Arrow(int byte) {
  if (byte == 'C') return Keyboard::Key::kRight;
  return byte == 'D' ? Keyboard::Key::kLeft : Keyboard::Key::kNone;
}

}  // namespace

Keyboard::Keyboard() {
  // A program in the background may not change the terminal: it would be stopped.
  terminal_ = isatty(STDIN_FILENO) == 1 && tcgetpgrp(STDIN_FILENO) == getpgrp() &&
              tcgetattr(STDIN_FILENO, &former_) == 0;
  if (!terminal_) return;
  termios raw = former_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  terminal_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

Keyboard::~Keyboard() {
  if (terminal_) tcsetattr(STDIN_FILENO, TCSANOW, &former_);
}

Keyboard::Key Keyboard::Read() {
  if (!terminal_) return Key::kNone;
  switch (NextByte()) {
    case ' ':
      return Key::kSpace;
    case 'n':
      return Key::kNext;
    case 'p':
      return Key::kPrevious;
    case '+':
      return Key::kFaster;
    case '-':
      return Key::kSlower;
    case 'b':
      return Key::kBookmark;
    case 'q':
      return Key::kQuit;
    case 0x1b:  // ESC [ C, ESC [ D
      return NextByte() == '[' ? Arrow(NextByte()) : Key::kNone;
    default:
      return Key::kNone;
  }
}

}  // namespace palpate
