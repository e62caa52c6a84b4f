#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The part of the Foxglove WebSocket protocol that the gateway speaks
// (github.com/foxglove/ws-protocol, docs/spec.md), without a socket: what the server says, and what
// a client may ask.  Nothing that a client sends is believed: parsers take any bytes.
namespace palpate::foxglove {

/// The first of a Sec-WebSocket-Protocol header's list that this server speaks; empty: none.
std::string_view ChooseSubprotocol(std::string_view offered);

struct Channel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;  ///< of its messages: "cdr", "json"
  std::string schema_name;
  std::string schema;
  std::string schema_encoding;  ///< "omgidl", "jsonschema"
};

enum class Level { kInfo = 0, kWarning = 1, kError = 2 };

/// @param session_id  tells a client whether it has come back to the same gateway.
/// @param role        what the client may do, as metadata; of the protocol's own is no word for it.
std::string ServerInfo(const std::string& session_id, bool clients_may_publish,
                       const std::string& role);
std::string Advertise(const std::vector<Channel>& channels);
std::string Status(Level level, const std::string& message);

/// What goes before a message's payload: opcode, subscription, time [ns].
using MessageHeader = std::array<std::uint8_t, 13>;
MessageHeader MakeMessageHeader(std::uint32_t subscription, std::int64_t time_ns);

struct Subscription {
  std::uint32_t id = 0;
  std::uint32_t channel = 0;
};
/// A channel that a client publishes on; `id` is the client's own.
struct ClientChannel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;
};

/// A client's text message.
struct Request {
  std::string op;
  std::vector<Subscription> subscriptions;  ///< of "subscribe"
  std::vector<std::uint32_t> ids;       ///< "unsubscribe": subscriptions; "unadvertise": channels
  std::vector<ClientChannel> channels;  ///< of "advertise"
};
/// Throws Error for what is none, but not for an operation that this server does not have: a newer
/// client may ask for it.
Request ParseRequest(std::string_view text);

/// A client's binary message.  The payload is a part of the bytes given.
struct ClientMessage {
  std::uint32_t channel = 0;
  std::string_view payload;
};
/// Throws Error for what is none.
ClientMessage ParseMessage(std::span<const std::uint8_t> bytes);

}  // namespace palpate::foxglove
