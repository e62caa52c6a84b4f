#include "tests/faults/hostile.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/math/random.h"

namespace palpate::faults {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

class Anything {
 public:
  explicit Anything(std::uint64_t seed) : random_(seed) {}

  double Number() {
    static const double odd[] = {0.0,
                                 -0.0,
                                 1e300,
                                 -1e300,
                                 1e-310,
                                 std::numeric_limits<double>::infinity(),
                                 -std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::quiet_NaN()};
    return random_.Below(3) == 0 ? random_.Uniform(-1.0, 1.0) : odd[random_.Below(8)];
  }
  std::uint32_t Word() {
    return random_.Below(2) == 0 ? static_cast<std::uint32_t>(random_.Below(8))
                                 : static_cast<std::uint32_t>(random_.Bits());
  }
  std::uint64_t Long() { return random_.Below(2) == 0 ? Word() : random_.Bits(); }
  bool Coin() { return random_.Below(2) == 0; }
  int Below(int n) { return random_.Below(n); }

  template <std::size_t N>
  void Text(char (&field)[N], const std::string& likely) {
    std::memset(field, 0, N);
    if (Coin()) return wire::FromText(likely, field);
    const std::size_t size = static_cast<std::size_t>(random_.Below(static_cast<int>(N)));
    for (std::size_t i = 0; i < size; ++i) field[i] = static_cast<char>(1 + random_.Below(255));
  }
  template <std::size_t N>
  void Numbers(double (&field)[N]) {
    for (double& value : field) value = Number();
  }

 private:
  Random random_;
};

/// The station that has a session, and its run: both are public.
struct Victim {
  std::string station = "hand";
  std::uint64_t run = 0, server_run = 0;
};

void Fill(Anything& any, const Victim& victim, wire::SessionRequest& s) {
  any.Text(s.station, victim.station);
  s.run = any.Coin() ? victim.run : any.Long();
  any.Text(s.scene, "cube");
  any.Text(s.tool, "");
  any.Text(s.device, "mouse");
  s.leave = any.Coin();
  for (auto& byte : s.leave_key) byte = static_cast<std::uint8_t>(any.Word());
}
void Fill(Anything& any, const Victim& victim, wire::WholeRequest& s) {
  any.Text(s.scene, "cube");
  s.request = any.Long();
  any.Text(s.by, victim.station);
}
void Fill(Anything& any, const Victim& victim, wire::ToolState& s) {
  any.Text(s.station, victim.station);
  any.Text(s.scene, "cube");
  s.pose_sequence = any.Long();
  any.Numbers(s.haptic_position_m);
  any.Numbers(s.haptic_orientation_wxyz);
  any.Numbers(s.graphic_position_m);
  any.Numbers(s.force_N);
  s.contacts = any.Word();
  s.faults = any.Word();
  s.points = any.Word();
}
void Fill(Anything& any, const Victim& victim, wire::StationStatistics& s) {
  any.Text(s.station, victim.station);
  s.run = any.Long();
  s.period_s = any.Number();
  s.ticks = any.Long();
  s.energy_J = any.Number();
  s.device_status = any.Word();
}
void Fill(Anything& any, const Victim& victim, wire::SolidBlock& s) {
  any.Text(s.scene, "cube");
  s.object_index = any.Word();
  s.block = any.Word();
  s.change = any.Long();
  s.server_run = any.Coin() ? victim.server_run : any.Long();
  any.Numbers(s.origin_m);
  s.spacing_m = any.Number();
  for (std::uint32_t& count : s.blocks) count = any.Word();
  s.cut = any.Coin();
}
void Fill(Anything& any, const Victim& victim, wire::GuideTarget& s) {
  any.Text(s.station, victim.station);
  s.run = any.Long();
  s.number = any.Long();
  any.Numbers(s.position_m);
  any.Numbers(s.orientation_wxyz);
}
void Fill(Anything& any, const Victim& victim, wire::HapticPose& s) {
  s.pose_sequence = any.Long();
  s.sample_time_ns = static_cast<std::int64_t>(any.Long());
  any.Numbers(s.position_m);
  any.Numbers(s.orientation_wxyz);
  any.Numbers(s.linear_velocity_m_s);
  s.buttons = any.Word();
  (void)victim;
}
void Fill(Anything& any, const Victim&, wire::Wrench& s) {
  s.pose_sequence = any.Long();
  any.Numbers(s.force_N);
  any.Numbers(s.torque_Nm);
  any.Numbers(s.graphic_position_m);
  for (auto& row : s.row) any.Numbers(row);
  s.region_m = any.Number();
  s.valid_s = any.Number();
  s.rows = any.Word();
}

template <class T>
class Flood {
 public:
  Flood(const dds::Participant& participant, const std::string& topic, dds::Qos qos)
      : writer_(participant, topic, qos) {}
  std::uint64_t Write(Anything& any, const Victim& victim) {
    T sample{};
    Fill(any, victim, sample);
    return writer_.Write(sample);
  }

 private:
  dds::Writer<T> writer_;
};

/// Waits up to 2 s for the session of the lab's station.
Victim FindVictim(const dds::Participant& service) {
  dds::Reader<wire::SessionState> states(service, dds::kSessionStateTopic, dds::Qos::kSession);
  Victim victim;
  for (int i = 0; i < 2000 && victim.run == 0; ++i) {
    wire::SessionState state{};
    while (states.Take(state)) {
      if (victim.station == state.station) {
        victim.run = state.run;
        victim.server_run = state.server_run;
      }
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  return victim;
}

int Connect(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

}  // namespace

std::uint64_t FloodDomain(int domain, std::uint64_t seed, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  const dds::Participant service = dds::Participant::Service(domain);
  const dds::Participant loop = dds::Participant::Loop(domain, {dds::Transport::kUdp, "as asked"});
  const Victim victim = FindVictim(service);
  Anything any(seed);
  Flood<wire::SessionRequest> requests(service, dds::kSessionRequestTopic, dds::Qos::kSession);
  Flood<wire::WholeRequest> wholes(service, dds::kWholeRequestTopic, dds::Qos::kSession);
  Flood<wire::ToolState> tools(service, dds::kToolStateTopic, dds::Qos::kStream);
  Flood<wire::StationStatistics> statistics(service, dds::kStationStatisticsTopic,
                                            dds::Qos::kStream);
  Flood<wire::SolidBlock> blocks(service, dds::kSolidBlockTopic, dds::Qos::kSession);
  Flood<wire::GuideTarget> guides(service, dds::kGuideTopic, dds::Qos::kStream);
  Flood<wire::HapticPose> poses(loop, dds::PoseTopic(victim.station, victim.run), dds::Qos::kLoop);
  Flood<wire::Wrench> wrenches(loop, dds::WrenchTopic(victim.station, victim.run), dds::Qos::kLoop);
  std::uint64_t written = 0;
  while (Clock::now() < end) {
    written += requests.Write(any, victim) + wholes.Write(any, victim) + tools.Write(any, victim) +
               statistics.Write(any, victim) + blocks.Write(any, victim) +
               guides.Write(any, victim) + poses.Write(any, victim) + wrenches.Write(any, victim);
    if (written % 80 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  return written;
}

std::uint64_t FloodNewKeys(int domain, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  const dds::Participant service = dds::Participant::Service(domain);
  const Victim victim = FindVictim(service);
  dds::Writer<wire::SolidBlock> blocks(service, dds::kSolidBlockTopic, dds::Qos::kSession);
  dds::Writer<wire::ToolState> tools(service, dds::kToolStateTopic, dds::Qos::kStream);
  dds::Writer<wire::StationStatistics> stations(service, dds::kStationStatisticsTopic,
                                                dds::Qos::kStream);
  dds::Writer<wire::ReplayState> replays(service, dds::kReplayStateTopic, dds::Qos::kSession);
  std::vector<std::uint8_t> surface(1000);
  wire::SolidBlock block{};
  wire::FromText("cube", block.scene);
  block.server_run = victim.server_run;
  block.surface._buffer = surface.data();
  block.surface._length = block.surface._maximum = static_cast<std::uint32_t>(surface.size());
  wire::ToolState tool{};
  wire::StationStatistics station{};
  wire::ReplayState replay{};
  std::uint32_t count = 0;
  while (Clock::now() < end) {
    block.block = ++count;
    block.change = count;
    wire::FromText("tool" + std::to_string(count), tool.station);
    wire::FromText("station" + std::to_string(count), station.station);
    replay.replay = count;
    blocks.Write(block);
    tools.Write(tool);
    stations.Write(station);
    replays.Write(replay);
    if (count % 20 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  return 4 * std::uint64_t{count};
}

std::uint64_t FloodPort(int port, std::uint64_t seed, double seconds) {
  static const char* const kBegins[] = {
      "GET / HTTP/1.1\r\nHost: localhost\r\n",
      "GET /healthz HTTP/1.1\r\nHost: ",
      "POST / HTTP/1.1\r\nContent-Length: 99999999999999\r\n\r\n",
      "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
      "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n",
      "\x16\x03\x01\x02",
      ""};
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  Random random(seed);
  std::uint64_t connections = 0;
  while (Clock::now() < end) {
    const int fd = Connect(port);
    if (fd < 0) {
      std::this_thread::sleep_for(milliseconds(10));
      continue;
    }
    ++connections;
    std::string bytes = kBegins[random.Below(6)];
    for (int i = random.Below(400); i > 0; --i) bytes += static_cast<char>(random.Below(256));
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t size =
          std::min<std::size_t>(bytes.size() - at, 1 + static_cast<std::size_t>(random.Below(200)));
      if (send(fd, bytes.data() + at, size, MSG_NOSIGNAL) < 0) break;
      at += size;
    }
    std::this_thread::sleep_for(milliseconds(random.Below(3)));
    close(fd);
  }
  return connections;
}

SlowLoris::SlowLoris(int port, int connections) {
  while (count_ < std::min(connections, 1000)) {
    const int fd = Connect(port);
    if (fd < 0) break;
    send(fd, "GET /healthz HTTP/1.1\r\nX: ", 26, MSG_NOSIGNAL);
    connections_[count_++] = fd;
  }
}

void SlowLoris::Go() {
  for (int i = 0; i < count_; ++i) send(connections_[i], "x", 1, MSG_NOSIGNAL);
}

SlowLoris::~SlowLoris() {
  for (int i = 0; i < count_; ++i) close(connections_[i]);
}

}  // namespace palpate::faults
