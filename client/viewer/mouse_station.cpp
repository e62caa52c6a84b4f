#include "client/viewer/mouse_station.h"

#include <charconv>
#include <csignal>

#include <spdlog/spdlog.h>

namespace palpate {
namespace {

constexpr std::int64_t kPatience_ns = 3'000'000'000;

}  // namespace

std::string ToMouseLine(const Pose& X, bool still) {
  std::string line;
  for (const double value : {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}) {
    char text[32];
    const char* end = std::to_chars(text, text + sizeof text, value).ptr;
    if (!line.empty()) line += ' ';
    line.append(static_cast<const char*>(text), end);
  }
  return line + (still ? " still\n" : "\n");
}

MouseStation::MouseStation(const std::string& program, const std::vector<std::string>& arguments)
    : child_(program, arguments, "the mouse's station",
             [](const std::string& line) { spdlog::debug("mouse: {}", line); }) {}

void MouseStation::LetGo(std::int64_t now_ns) {
  if (let_go_ns_ == 0) let_go_ns_ = now_ns;
  child_.CloseInput();
}

bool MouseStation::Poll(std::int64_t now_ns) {
  if (!child_.Poll()) return false;
  if (let_go_ns_ != 0 && now_ns - let_go_ns_ > kPatience_ns) child_.Signal(SIGKILL);
  return true;
}

}  // namespace palpate
