#include "client/viewer/foxglove.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include <nlohmann/json.hpp>

#include "client/viewer/json_text.h"
#include "client/viewer/viewer_limits.h"
#include "common/text/quoted.h"

namespace palpate::foxglove {
namespace {

using Json = nlohmann::json;

constexpr std::uint8_t kMessageData = 1;
static_assert(std::endian::native == std::endian::little, "the protocol's integers are");

bool ReadId(const Json& value, std::uint32_t& id) {
  if (!value.is_number_unsigned()) return false;
  const auto number = value.get<std::uint64_t>();
  id = static_cast<std::uint32_t>(number);
  return number <= std::numeric_limits<std::uint32_t>::max();
}

bool ReadId(const Json& object, const char* field, std::uint32_t& id) {
  const auto found = object.find(field);
  return found != object.end() && ReadId(*found, id);
}

bool ReadText(const Json& object, const char* field, std::string& text) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_string()) return false;
  text = found->get<std::string>();
  return true;
}

/// A bounded list of the request; null where there is none.
const Json* List(const Json& object, const char* field) {
  const auto found = object.find(field);
  if (found == object.end() || !found->is_array() || found->size() > ViewerLimits::kMostItems)
    return nullptr;
  return &*found;
}

bool ReadSubscriptions(const Json& message, Request& request) {
  const Json* list = List(message, "subscriptions");
  return list != nullptr && std::ranges::all_of(*list, [&](const Json& item) {
           Subscription& s = request.subscriptions.emplace_back();
           return item.is_object() && ReadId(item, "id", s.id) &&
                  ReadId(item, "channelId", s.channel);
         });
}

bool ReadChannels(const Json& message, Request& request) {
  const Json* list = List(message, "channels");
  return list != nullptr && std::ranges::all_of(*list, [&](const Json& item) {
           ClientChannel& c = request.channels.emplace_back();
           return item.is_object() && ReadId(item, "id", c.id) &&
                  ReadText(item, "topic", c.topic) && ReadText(item, "encoding", c.encoding);
         });
}

bool ReadIds(const Json& message, const char* field, Request& request) {
  const Json* list = List(message, field);
  return list != nullptr && std::ranges::all_of(*list, [&](const Json& item) {
           return ReadId(item, request.ids.emplace_back());
         });
}

}  // namespace

std::string_view ChooseSubprotocol(std::string_view offered) {
  while (!offered.empty()) {
    std::string_view name = offered.substr(0, offered.find(','));
    offered.remove_prefix(std::min(name.size() + 1, offered.size()));
    name.remove_prefix(std::min(name.find_first_not_of(" \t"), name.size()));
    name = name.substr(0, name.find_last_not_of(" \t") + 1);
    for (const std::string_view known : kSubprotocols) {
      if (name == known) return known;
    }
  }
  return {};
}

std::string ServerInfo(const std::string& session_id, bool clients_may_publish,
                       const std::string& role) {
  Json info = {{"op", "serverInfo"},
               {"name", "palpate-viewer " PALPATE_VERSION},
               {"capabilities", Json::array()},
               {"metadata", {{"role", role}}},
               {"sessionId", session_id}};
  if (clients_may_publish) {
    info["capabilities"].push_back("clientPublish");
    info["supportedEncodings"] = {"json"};
  }
  return ToText(info);
}

std::string Advertise(const std::vector<Channel>& channels) {
  Json list = Json::array();
  for (const Channel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", channel.encoding},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", channel.schema_encoding}});
  }
  return ToText(Json({{"op", "advertise"}, {"channels", list}}));
}

std::string Status(Level level, const std::string& message) {
  return ToText(Json({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}}));
}

MessageHeader MakeMessageHeader(std::uint32_t subscription, std::int64_t time_ns) {
  MessageHeader header;
  header[0] = kMessageData;
  std::memcpy(&header[1], &subscription, sizeof subscription);
  std::memcpy(&header[5], &time_ns, sizeof time_ns);
  return header;
}

std::optional<Request> ParseRequest(std::string_view text, std::string& complaint) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) {
    complaint = "a text message that is no JSON object";
    return std::nullopt;
  }
  Request request;
  if (!ReadText(message, "op", request.op_name)) {
    complaint = "a text message without 'op'";
    return std::nullopt;
  }
  bool good = true;
  if (request.op_name == "subscribe") {
    request.op = Request::Op::kSubscribe;
    good = ReadSubscriptions(message, request);
  } else if (request.op_name == "unsubscribe") {
    request.op = Request::Op::kUnsubscribe;
    good = ReadIds(message, "subscriptionIds", request);
  } else if (request.op_name == "advertise") {
    request.op = Request::Op::kAdvertise;
    good = ReadChannels(message, request);
  } else if (request.op_name == "unadvertise") {
    request.op = Request::Op::kUnadvertise;
    good = ReadIds(message, "channelIds", request);
  }
  if (good) return request;
  complaint = Quoted(request.op_name) + " has not the fields of the protocol";
  return std::nullopt;
}

std::optional<ClientMessage> ParseMessage(std::span<const std::uint8_t> bytes,
                                          std::string& complaint) {
  ClientMessage message;
  constexpr std::size_t kHeader = 1 + sizeof message.channel;
  if (bytes.size() < kHeader) {
    complaint = "a binary message that is cut short";
    return std::nullopt;
  }
  if (bytes[0] != kMessageData) {
    complaint = "a binary message with opcode " + std::to_string(bytes[0]);
    return std::nullopt;
  }
  std::memcpy(&message.channel, &bytes[1], sizeof message.channel);
  message.payload = {reinterpret_cast<const char*>(bytes.data()) + kHeader, bytes.size() - kHeader};
  return message;
}

}  // namespace palpate::foxglove
