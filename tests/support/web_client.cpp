#include "tests/support/web_client.h"

#include <chrono>
#include <cstring>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

namespace palpate::test {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace net = boost::asio;
namespace websocket = beast::websocket;
using Json = nlohmann::json;
using net::ip::tcp;

tcp::endpoint At(int port) {
  return {net::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port)};
}

}  // namespace

HttpAnswer Get(int port, const std::string& target,
               const std::map<std::string, std::string>& headers, const std::string& method) {
  HttpAnswer answer;
  net::io_context io;
  beast::tcp_stream stream(io);
  beast::error_code error;
  stream.socket().connect(At(port), error);
  if (error) return answer;
  std::string request = method + " " + target + " HTTP/1.1\r\n";
  if (!headers.contains("Host")) request += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  for (const auto& [name, value] : headers) request += name + ": " + value + "\r\n";
  if (!headers.contains("Connection")) request += "Connection: close\r\n";
  net::write(stream.socket(), net::buffer(request + "\r\n"), error);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(100'000'000);
  if (method == "HEAD") parser.skip(true);
  http::read(stream.socket(), buffer, parser, error);
  if (!parser.is_header_done()) return answer;
  answer.status = static_cast<int>(parser.get().result_int());
  for (const auto& field : parser.get()) {
    std::string name(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    answer.headers[name] = std::string(field.value());
  }
  answer.body = parser.get().body();
  return answer;
}

HttpAnswer Handshake(int port, const std::string& subprotocols, const std::string& origin,
                     std::map<std::string, std::string> headers) {
  headers.insert({{"Upgrade", "websocket"},
                  {"Connection", "Upgrade"},
                  {"Sec-WebSocket-Version", "13"},
                  {"Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="}});
  if (!subprotocols.empty()) headers["Sec-WebSocket-Protocol"] = subprotocols;
  if (!origin.empty()) headers["Origin"] = origin;
  return Get(port, "/", headers);
}

struct KeptConnection::State {
  net::io_context io;
  beast::tcp_stream stream{io};
  beast::flat_buffer buffer;
};

KeptConnection::KeptConnection(int port) : state_(std::make_unique<State>()) {
  beast::error_code error;
  state_->stream.socket().connect(At(port), error);
}

KeptConnection::~KeptConnection() = default;

bool KeptConnection::Get(const std::string& target) {
  beast::error_code error;
  const std::string request = "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  net::write(state_->stream.socket(), net::buffer(request), error);
  if (error) return false;
  http::response_parser<http::string_body> parser;
  http::read(state_->stream.socket(), state_->buffer, parser, error);
  return !error;
}

bool KeptConnection::Closed() {
  bool closed = false;
  state_->stream.expires_after(std::chrono::seconds(20));
  char byte = 0;
  state_->stream.async_read_some(net::buffer(&byte, 1), [&](beast::error_code error, std::size_t) {
    closed = error && error != beast::error::timeout;
  });
  state_->io.restart();
  state_->io.run();
  return closed;
}

struct WebClient::State {
  net::io_context io;
  websocket::stream<tcp::socket, false> socket{io};  // false: nothing is deflated
  beast::flat_buffer buffer;
  std::deque<Json> texts;
  std::deque<Message> messages;
  bool open = false;
  std::string subprotocol;
  bool ended = false;

  void Read() {
    socket.async_read(buffer, [this](beast::error_code error, std::size_t) {
      if (error) {
        open = false;
        ended = true;
        return;
      }
      const auto* bytes = static_cast<const std::uint8_t*>(buffer.cdata().data());
      const std::size_t size = buffer.size();
      if (socket.got_text()) {
        texts.push_back(Json::parse(bytes, bytes + size));
      } else if (size >= 13 && bytes[0] == 1) {
        Message message;
        std::memcpy(&message.subscription, bytes + 1, 4);
        std::memcpy(&message.time_ns, bytes + 5, 8);
        message.payload.assign(bytes + 13, bytes + size);
        messages.push_back(std::move(message));
      }
      buffer.clear();
      Read();
    });
  }

  template <class Condition>
  bool RunUntil(Condition condition, double seconds = 20.0) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition()) {
      if (io.stopped()) io.restart();
      const auto now = std::chrono::steady_clock::now();
      if (now > end || ended) return condition();
      io.run_one_for(std::chrono::milliseconds(20));
    }
    return true;
  }
};

WebClient::WebClient(int port, const std::string& subprotocols, const std::string& origin,
                     int receive_buffer, const std::map<std::string, std::string>& headers)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  beast::error_code error;
  tcp::socket& tcp_socket = s.socket.next_layer();
  tcp_socket.open(tcp::v4(), error);
  if (receive_buffer > 0) {
    tcp_socket.set_option(net::socket_base::receive_buffer_size(receive_buffer), error);
  }
  tcp_socket.connect(At(port), error);
  if (error) return;
  s.socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    if (!subprotocols.empty()) {
      request.set(http::field::sec_websocket_protocol, subprotocols);
    }
    if (!origin.empty()) request.set(http::field::origin, origin);
    for (const auto& [name, value] : headers) request.set(name, value);
  }));
  websocket::response_type response;
  s.socket.handshake(response, "127.0.0.1:" + std::to_string(port), "/", error);
  s.subprotocol = std::string(response[http::field::sec_websocket_protocol]);
  s.open = !error;
  s.socket.read_message_max(100'000'000);
  if (s.open) s.Read();
}

WebClient::~WebClient() = default;

bool WebClient::open() const {
  return state_->open;
}
std::string WebClient::subprotocol() const {
  return state_->subprotocol;
}

int WebClient::closed() {
  state_->RunUntil([this] { return state_->ended; });
  return state_->ended ? state_->socket.reason().code : 0;
}

void WebClient::SendText(const std::string& text) {
  beast::error_code error;
  state_->socket.text(true);
  state_->socket.write(net::buffer(text), error);
}

void WebClient::SendBinary(const std::string& bytes) {
  beast::error_code error;
  state_->socket.binary(true);
  state_->socket.write(net::buffer(bytes), error);
}

void WebClient::Subscribe(std::uint32_t id, std::uint32_t channel) {
  SendText(
      Json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}.dump());
}

void WebClient::SendMouse(const Json& command) {
  SendOn(1, "/palpate/mouse", command);
}

void WebClient::SendReplay(const Json& wish) {
  SendOn(2, "/palpate/replay", wish);
}

void WebClient::SendOperate(const Json& command) {
  SendOn(3, "/palpate/operate", command);
}

void WebClient::SendExam(const Json& wish) {
  SendOn(5, "/palpate/exam", wish);
}

void WebClient::SendTrial(const Json& command) {
  SendOn(6, "/palpate/trial", command);
}

void WebClient::SendClass(const Json& command) {
  SendOn(4, "/palpate/class", command);
}

void WebClient::SendOn(std::uint32_t channel, const std::string& topic, const Json& message) {
  if (advertised_.insert(channel).second) {
    SendText(Json{{"op", "advertise"},
                  {"channels",
                   {{{"id", channel}, {"topic", topic}, {"encoding", "json"}, {"schemaName", ""}}}}}
                 .dump());
  }
  std::string header("\x01\0\0\0\0", 5);
  header[1] = static_cast<char>(channel);
  SendBinary(header + message.dump());
}

Json WebClient::NextJson(const std::string& op) {
  Json found;
  state_->RunUntil([&] {
    while (!state_->texts.empty() && found.is_null()) {
      Json text = std::move(state_->texts.front());
      state_->texts.pop_front();
      if (text.value("op", "") == op) found = std::move(text);
    }
    return !found.is_null();
  });
  return found;
}

std::string WebClient::NextStatus() {
  return NextJson("status").value("message", "");
}

std::optional<WebClient::Message> WebClient::Next(std::uint32_t subscription, double seconds) {
  std::optional<Message> found;
  state_->RunUntil(
      [&] {
        auto& messages = state_->messages;
        for (auto it = messages.begin(); it != messages.end(); ++it) {
          if (it->subscription != subscription) continue;
          found = std::move(*it);
          messages.erase(it);
          return true;
        }
        return false;
      },
      seconds);
  return found;
}

void WebClient::Run(double seconds) {
  state_->RunUntil([] { return false; }, seconds);
}

}  // namespace palpate::test
