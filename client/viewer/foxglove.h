#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// The part of the Foxglove WebSocket protocol that the gateway speaks
// (github.com/foxglove/ws-protocol, docs/spec.md), without a socket: the server's messages, and the
// parsers of a client's.  The parsers accept arbitrary bytes.
namespace palpate::foxglove {

/// Returns the first subprotocol in a Sec-WebSocket-Protocol header that this server
/// speaks; empty: none.
std::string_view ChooseSubprotocol(std::string_view offered);

struct Channel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;  ///< encoding of its messages: "cdr", "json"
  std::string schema_name;
  std::string schema;
  std::string schema_encoding;  ///< "omgidl", "jsonschema"
};

enum class Level { kInfo = 0, kWarning = 1, kError = 2 };

/// @param session_id  tells a client whether it has come back to the same gateway.
/// @param role        what the client may do, sent as metadata, since the protocol has no
/// field for it.
std::string ServerInfo(const std::string& session_id, bool clients_may_publish,
                       const std::string& role);
std::string Advertise(const std::vector<Channel>& channels);
std::string Status(Level level, const std::string& message);

/// The bytes before a message's payload: opcode, subscription, time [ns].
using MessageHeader = std::array<std::uint8_t, 13>;
MessageHeader MakeMessageHeader(std::uint32_t subscription, std::int64_t time_ns);

struct Subscription {
  std::uint32_t id = 0;
  std::uint32_t channel = 0;
};
/// A channel on which a client publishes; the client chooses `id`.
struct ClientChannel {
  std::uint32_t id = 0;
  std::string topic;
  std::string encoding;
};

/// A client's text message.
struct Request {
  std::string op;
  std::vector<Subscription> subscriptions;  ///< "subscribe"
  std::vector<std::uint32_t> ids;       ///< "unsubscribe": subscriptions; "unadvertise": channels
  std::vector<ClientChannel> channels;  ///< "advertise"
};
/// Throws Error if it is not valid, but accepts operations that this server does not know: a newer
/// client may send them.
Request ParseRequest(std::string_view text);

/// A client's binary message.  The payload is a view into the parsed bytes.
struct ClientMessage {
  std::uint32_t channel = 0;
  std::string_view payload;
};
/// Throws Error if it is not valid.
ClientMessage ParseMessage(std::span<const std::uint8_t> bytes);

}  // namespace palpate::foxglove
