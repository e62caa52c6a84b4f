#include "client/load/process_use.h"

#include <array>
#include <filesystem>
#include <set>
#include <sstream>

#include <unistd.h>

#include "common/dds/server_lock.h"
#include "common/dds/socket_owner.h"
#include "common/files/whole_file.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// The longest file is the table of sockets: 150 bytes for each of a hundred thousand.
constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 20;

std::string TextOf(const fs::path& file) {
  return TryReadWholeFile(file, kMostBytes).value_or("");
}

double Seconds(std::uint64_t ticks) {
  static const double kPerSecond = static_cast<double>(sysconf(_SC_CLK_TCK));
  return static_cast<double>(ticks) / kPerSecond;
}

/// Adds the inodes of the sockets that listen on the port, from a table like /proc/net/tcp.
void AddListeners(const std::string& table, int port, std::set<std::string>& sockets) {
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);  // the heading
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::array<std::string, 10> word;
    for (std::string& w : word) words >> w;
    const std::size_t colon = word[1].rfind(':');
    const bool listens = word[3] == "0A";
    if (colon == std::string::npos || !listens) continue;
    if (std::stoi(word[1].substr(colon + 1), nullptr, 16) != port) continue;
    sockets.insert("socket:[" + word[9] + "]");
  }
}

}  // namespace

std::optional<std::uint64_t> TicksOf(const std::string& line) {
  // "PID (NAME) STATE ...": the name may contain blanks and brackets.  Times are fields 14 and 15.
  const std::size_t close = line.rfind(')');
  if (close == std::string::npos) return std::nullopt;
  std::istringstream rest(line.substr(close + 1));
  std::string skipped;
  for (int field = 3; field < 14; ++field) rest >> skipped;
  std::uint64_t user = 0;
  std::uint64_t system = 0;
  if (!(rest >> user >> system)) return std::nullopt;
  return user + system;
}

std::optional<ProcessTimes> TimesOf(int pid) {
  const auto ticks = TicksOf(TextOf(fs::path("/proc") / std::to_string(pid) / "stat"));
  if (!ticks) return std::nullopt;
  return ProcessTimes{SteadyNanoseconds(), Seconds(*ticks)};
}

double UseBetween(const ProcessTimes& begin, const ProcessTimes& end) {
  const double seconds = 1e-9 * static_cast<double>(end.time_ns - begin.time_ns);
  return seconds > 0.0 ? (end.cpu_s - begin.cpu_s) / seconds : 0.0;
}

MachineTimes ParseMachineTimes(const std::string& stat) {
  std::istringstream line(stat.substr(0, stat.find('\n')));
  std::string cpu;
  line >> cpu;
  MachineTimes times;
  // user nice system idle iowait irq softirq steal; user already includes guests.
  std::uint64_t ticks = 0;
  for (int field = 0; field < 8 && line >> ticks; ++field) {
    times.all += ticks;
    if (field != 3 && field != 4) times.busy += ticks;
  }
  return times;
}

MachineTimes MachineTimesNow() {
  return ParseMachineTimes(TextOf("/proc/stat"));
}

double BusyBetween(const MachineTimes& begin, const MachineTimes& end) {
  if (end.all <= begin.all) return 0.0;
  return static_cast<double>(end.busy - begin.busy) / static_cast<double>(end.all - begin.all);
}

std::string LoadAverages() {
  std::istringstream text(TextOf("/proc/loadavg"));
  std::string one, five, fifteen;
  text >> one >> five >> fifteen;
  return one + " " + five + " " + fifteen;
}

std::optional<int> ServerOf(int domain) {
  const std::optional<int> pid = ServerProcess(domain);
  if (!pid || TextOf(fs::path("/proc") / std::to_string(*pid) / "comm") != "palpate-server\n") {
    return std::nullopt;
  }
  return pid;
}

std::optional<int> ListenerAt(int port) {
  std::set<std::string> sockets;
  for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    AddListeners(TextOf(table), port, sockets);
  }
  return sockets.empty() ? std::nullopt : SocketOwner(sockets);
}

}  // namespace palpate
