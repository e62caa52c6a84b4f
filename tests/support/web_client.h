#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace palpate::test {

/// The answer to a GET request.
struct HttpAnswer {
  int status = 0;                              ///< 0: no answer
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;
};
/// @param target   sent unchanged.
/// @param headers  sent besides Connection and Host, which is the address unless it is given here.
HttpAnswer Get(int port, const std::string& target,
               const std::map<std::string, std::string>& headers = {},
               const std::string& method = "GET");

/// Returns the answer to a WebSocket handshake: status 101 if it succeeds.
HttpAnswer Handshake(int port, const std::string& subprotocols, const std::string& origin = "",
                     std::map<std::string, std::string> headers = {});

/// An HTTP connection that is kept open.
class KeptConnection {
 public:
  explicit KeptConnection(int port);
  ~KeptConnection();
  /// Sends a GET and reads the answer; false if the gateway has closed the connection.
  bool Get(const std::string& target);
  /// Waits until the gateway closes the connection, at most 20 s.
  bool Closed();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A viewer for tests: a WebSocket client of the Foxglove protocol.  Every wait ends after 20 s.
class WebClient {
 public:
  struct Message {
    std::uint32_t subscription = 0;
    std::int64_t time_ns = 0;
    std::vector<std::uint8_t> payload;
  };

  /// @param receive_buffer  size of the kernel's receive buffer [bytes]; 0: the default.
  explicit WebClient(int port, const std::string& subprotocols = "foxglove.websocket.v1",
                     const std::string& origin = "", int receive_buffer = 0,
                     const std::map<std::string, std::string>& headers = {});
  ~WebClient();

  bool open() const;
  std::string subprotocol() const;
  /// Returns the code with which the server closed the connection; 0: it has not.
  int closed();

  void SendText(const std::string& text);
  void SendBinary(const std::string& bytes);
  void Subscribe(std::uint32_t id, std::uint32_t channel);
  /// Sends on the client's channel 1, which it advertises first.
  void SendMouse(const nlohmann::json& command);
  /// On its channel 2.
  void SendReplay(const nlohmann::json& wish);
  /// On its channel 3.
  void SendOperate(const nlohmann::json& command);
  /// On its channel 4.
  void SendClass(const nlohmann::json& command);
  /// On its channel 5.
  void SendExam(const nlohmann::json& wish);
  /// On its channel 6.
  void SendTrial(const nlohmann::json& command);

  /// Returns the next JSON message with this `op`, skipping others; null if none came.
  nlohmann::json NextJson(const std::string& op);
  /// Returns the text of the next status message; empty if none came.
  std::string NextStatus();
  std::optional<Message> Next(std::uint32_t subscription, double seconds = 20.0);
  /// Receives messages for some time, because the socket stalls otherwise.
  void Run(double seconds);

 private:
  struct State;
  std::unique_ptr<State> state_;
  void SendOn(std::uint32_t channel, const std::string& topic, const nlohmann::json& message);

  std::set<std::uint32_t> advertised_;
};

}  // namespace palpate::test
