#include "tests/devices/haply/fake_inverse_service.h"

#include <chrono>
#include <cstdlib>

#include <arpa/inet.h>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"

namespace palpate::test {
namespace {

namespace asio = boost::asio;
using Json = nlohmann::json;

constexpr int kLook_ms = 1;

bool Readable(int fd) {
  pollfd wait{fd, POLLIN, 0};
  return poll(&wait, 1, kLook_ms) > 0;
}

}  // namespace

FakeInverseService::FakeInverseService() {
  Listen();
}

FakeInverseService::~FakeInverseService() {
  Die();
}

void FakeInverseService::Listen() {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port_));
  socklen_t size = sizeof address;
  if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listener_, 4) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    std::abort();
  }
  port_ = ntohs(address.sin_port);
  dies_ = false;
  thread_ = std::thread([this] { Run(); });
}

void FakeInverseService::Die() {
  if (!thread_.joinable()) return;
  dies_ = true;
  thread_.join();
  close(listener_);
}

void FakeInverseService::ComeBack() {
  Listen();
}

void FakeInverseService::Run() {
  while (!dies_) {
    if (!Readable(listener_)) continue;
    const int connection = accept(listener_, nullptr, nullptr);
    if (connection < 0) continue;
    try {
      Serve(connection);
    } catch (const boost::system::system_error&) {
      // The client has gone.
    }
  }
}

void FakeInverseService::Serve(int connection) {
  asio::io_context io;
  boost::beast::websocket::stream<asio::ip::tcp::socket, false> socket(io);
  socket.next_layer().assign(asio::ip::tcp::v4(), connection);
  socket.next_layer().set_option(asio::ip::tcp::no_delay(true));
  socket.accept();
  socket.text(true);
  socket.write(asio::buffer(State(true)));
  boost::beast::flat_buffer buffer;
  for (bool first = true; !dies_; first = false) {
    while (!dies_ && (stalls || (socket.next_layer().available() == 0 && !Readable(connection)))) {
      if (stalls) std::this_thread::sleep_for(std::chrono::milliseconds(kLook_ms));
    }
    if (dies_) return;
    buffer.clear();
    socket.read(buffer);
    const std::string text(static_cast<const char*>(buffer.data().data()), buffer.size());
    const Json vector =
        Json::parse(text).at("inverse3").at(0).at("commands").at("set_cursor_force").at("vector");
    {
      const std::lock_guard lock(mutex_);
      if (first) first_command_ = text;
      force_ = {vector.at("x").get<double>(), vector.at("y").get<double>(),
                vector.at("z").get<double>()};
      if (force_ != std::array<double, 3>{}) last_force_ns = SteadyNanoseconds();
    }
    ++commands;
    if (delay_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
    std::string reply;
    {
      const std::lock_guard lock(mutex_);
      reply = lie_;
    }
    socket.write(asio::buffer(reply.empty() ? State(false) : reply));
  }
}

std::string FakeInverseService::State(bool first) {
  const std::lock_guard lock(mutex_);
  if (first && !first_lie_.empty()) return first_lie_;
  const auto xyz = [](const std::array<double, 3>& v) {
    return Json{{"x", v[0]}, {"y", v[1]}, {"z", v[2]}};
  };
  Json arm;
  arm["device_id"] = "049D";
  if (first) arm["config"] = {{"type", "inverse3"}, {"preset", "defaults"}};
  arm["state"]["cursor_position"] = xyz(position_);
  arm["state"]["cursor_velocity"] = xyz({});
  arm["state"]["current_cursor_force"] = xyz(force_);
  arm["state"]["control_mode"] = "force";
  arm["status"] = {{"calibrated", calibrated.load()}};
  Json message;
  message["inverse3"] = Json::array({arm});
  message["wireless_verse_grip"] = Json::array();
  if (grip_there) {
    Json grip;
    grip["device_id"] = "61548";
    grip["state"]["orientation"] = {{"w", orientation_[0]},
                                    {"x", orientation_[1]},
                                    {"y", orientation_[2]},
                                    {"z", orientation_[3]}};
    grip["state"]["buttons"] = {
        {"a", (buttons & 1) != 0}, {"b", (buttons & 2) != 0}, {"c", (buttons & 4) != 0}};
    message["wireless_verse_grip"].push_back(grip);
  }
  if (first) message["session_id"] = 7;
  return message.dump();
}

void FakeInverseService::SetPosition(const std::array<double, 3>& position) {
  const std::lock_guard lock(mutex_);
  position_ = position;
}
void FakeInverseService::SetOrientation(const std::array<double, 4>& wxyz) {
  const std::lock_guard lock(mutex_);
  orientation_ = wxyz;
}
void FakeInverseService::Lie(const std::string& text) {
  const std::lock_guard lock(mutex_);
  lie_ = text;
}
void FakeInverseService::LieFirst(const std::string& text) {
  const std::lock_guard lock(mutex_);
  first_lie_ = text;
}
std::string FakeInverseService::FirstMessage() {
  return State(true);
}
std::array<double, 3> FakeInverseService::force() {
  const std::lock_guard lock(mutex_);
  return force_;
}
std::string FakeInverseService::first_command() {
  const std::lock_guard lock(mutex_);
  return first_command_;
}

}  // namespace palpate::test
