#include "devices/mouse/mouse_device.h"

#include <array>
#include <cerrno>
#include <cstdint>

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "common/bur_button.h"
#include "common/error.h"
#include "common/text/number_of.h"
#include "devices/device_factory.h"

namespace palpate {
namespace {

constexpr double kFarthest_m = 10.0;
constexpr std::string_view kSpace = " \t\r";

std::string_view TakeWord(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kSpace), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kSpace));
  rest.remove_prefix(word.size());
  return word;
}

constexpr std::size_t kLongestLine = 512;
constexpr int kComplaints = 5;

}  // namespace

std::optional<MouseLine> ParseMouseLine(std::string_view line, std::string& complaint) {
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  std::array<double, 7> number{};
  std::string_view rest = line;
  for (std::size_t i = 0; i < number.size(); ++i) {
    const std::string_view word = TakeWord(rest);
    if (i == 0 && word == "release" && TakeWord(rest).empty()) return MouseLine{};
    const auto value = NumberOf<double>(word);
    if (!value) return refuse("give 'x y z qw qx qy qz', seven numbers, or 'release'");
    number[i] = *value;
  }
  const std::string_view more = TakeWord(rest);
  const bool still = more == "still";
  if (!(still || more.empty()) || !TakeWord(rest).empty()) {
    return refuse("more than seven numbers and 'still'");
  }
  Pose X;
  X.p = Vec3(number[0], number[1], number[2]);
  X.q = Quat(number[3], number[4], number[5], number[6]);
  // maxCoeff may ignore a NaN; comparisons with one are false.
  if (!X.p.allFinite() || X.p.cwiseAbs().maxCoeff() > kFarthest_m) {
    return refuse("a position beyond 10 m");
  }
  const double norm = X.q.norm();
  if (!(norm >= 1e-3 && norm <= 1e3)) return refuse("a quaternion that is no rotation");
  X.q.coeffs() /= norm;
  return MouseLine{X, still};
}

MouseDevice::MouseDevice(int lines, const Pose& start)
    : BlindDevice("mouse (poses from standard input)", 2.0 * kFarthest_m, start),
      lines_(lines),
      stop_(eventfd(0, EFD_CLOEXEC)) {
  if (stop_ < 0)
    throw Error("mouse: cannot create an eventfd; raise 'ulimit -n' if too many files are open");
  reader_ = std::thread([this] { ReadLines(); });
}

MouseDevice::~MouseDevice() {
  const std::uint64_t one = 1;
  if (write(stop_, &one, sizeof one) < 0) {
    // The stop event is already signalled.
  }
  reader_.join();
  close(stop_);
}

void MouseDevice::ReadLines() {
  std::string line;
  bool skip = false;  // true during the rest of a line that is too long
  for (;;) {
    pollfd wait[2] = {{lines_, POLLIN, 0}, {stop_, POLLIN, 0}};
    if (poll(wait, 2, -1) < 0 && errno == EINTR) continue;
    if (wait[1].revents != 0) break;
    char buffer[4096];
    const ssize_t n = read(lines_, buffer, sizeof buffer);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0) break;
    for (const char c : std::string_view(buffer, static_cast<std::size_t>(n))) {
      if (c == '\n') {
        if (!skip) TakeLine(line);
        line.clear();
        skip = false;
      } else if (line.size() < kLongestLine) {
        line += c;
      } else if (!skip) {
        skip = true;
        TakeLine(line);  // which reports it
      }
    }
  }
  if (!line.empty() && !skip) TakeLine(line);
  ended_.store(true, std::memory_order_release);
}

void MouseDevice::TakeLine(std::string_view line) {
  std::string complaint;
  if (const auto order = ParseMouseLine(line, complaint)) {
    orders_.Write({!order->X_WT, order->still, order->X_WT.value_or(Pose{})});
  } else if (++bad_lines_ <= kComplaints) {
    spdlog::warn("mouse: line '{}' is ignored: {}{}", line.substr(0, 60), complaint,
                 bad_lines_ == kComplaints ? "; further ones are not reported" : "");
  }
}

DeviceSample MouseDevice::Read() noexcept {
  if (Order order; orders_.Read(order)) {
    let_go_ = order.release;
    if (order.release) {
      hand_.LetGo();
    } else {
      hand_.Follow(order.X_WT);
      buttons_ = order.still ? kStillBurButton : 0;
    }
  }
  return {hand_.pose(), hand_.twist(), buttons_, kDeviceForcesIgnored};
}

const char* MouseDevice::activity() const noexcept {
  if (let_go_) return "let go";
  if (!hand_.follows()) return "waits for the mouse";
  return hand_.held_back() ? "follows, as far as it may press" : "follows";
}

DeviceKind MouseKind() {
  return {.name = "mouse",
          .what = "targets read from standard input; renders no force",
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<MouseDevice>(STDIN_FILENO, options.start);
          }};
}

}  // namespace palpate
