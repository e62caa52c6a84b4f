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

int Keyboard::Read() {
  const int key = terminal_ ? NextByte() : kNone;
  if (key != 0x1b) return key;
  // ESC [ C, ESC [ D
  if (NextByte() != '[') return kNone;
  const int arrow = NextByte();
  return arrow == 'C' ? kRight : arrow == 'D' ? kLeft : kNone;
}

}  // namespace palpate
