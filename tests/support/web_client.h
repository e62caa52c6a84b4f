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

/// What a GET was answered.
struct HttpAnswer {
  int status = 0;                              ///< 0: nobody answered
  std::map<std::string, std::string> headers;  ///< names in small letters
  std::string body;
};
/// @param target   sent as it is.
/// @param headers  beside Host, which is the address unless it is given, and Connection.
HttpAnswer Get(int port, const std::string& target,
               const std::map<std::string, std::string>& headers = {},
               const std::string& method = "GET");

/// What a handshake is answered: status 101 where it succeeds.
HttpAnswer Handshake(int port, const std::string& subprotocols, const std::string& origin = "",
                     std::map<std::string, std::string> headers = {});

/// A connection that speaks HTTP, and is kept.
class KeptConnection {
 public:
  explicit KeptConnection(int port);
  ~KeptConnection();
  /// Sends a GET and reads what it is answered; false where the gateway has closed.
  bool Get(const std::string& target);
  /// Waits until the gateway closes it, 20 s at most.
  bool Closed();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A viewer: a WebSocket client that speaks the Foxglove protocol, for tests.  Waits at most 20 s
/// for anything.
class WebClient {
 public:
  struct Message {
    std::uint32_t subscription = 0;
    std::int64_t time_ns = 0;
    std::vector<std::uint8_t> payload;
  };

  /// @param receive_buffer  what the kernel holds of what is not read [bytes]; 0: its own choice.
  explicit WebClient(int port, const std::string& subprotocols = "foxglove.websocket.v1",
                     const std::string& origin = "", int receive_buffer = 0,
                     const std::map<std::string, std::string>& headers = {});
  ~WebClient();

  bool open() const;
  std::string subprotocol() const;
  /// Code that the server closed with; 0: it has not.
  int closed();

  void SendText(const std::string& text);
  void SendBinary(const std::string& bytes);
  void Subscribe(std::uint32_t id, std::uint32_t channel);
  /// On the client's channel 1, which it advertises first.
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

  /// The next JSON message with this `op`; earlier ones of others are passed over.  Null: none
  /// came.
  nlohmann::json NextJson(const std::string& op);
  /// What the next status message says; empty: none came.
  std::string NextStatus();
  /// The next message of a subscription.
  std::optional<Message> Next(std::uint32_t subscription, double seconds = 20.0);
  /// Takes what comes for some time; where not, the socket stalls.
  void Run(double seconds);

 private:
  struct State;
  std::unique_ptr<State> state_;
  void SendOn(std::uint32_t channel, const std::string& topic, const nlohmann::json& message);

  std::set<std::uint32_t> advertised_;
};

}  // namespace palpate::test
