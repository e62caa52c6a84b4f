#include "client/viewer/foxglove.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/error.h"

namespace palpate::foxglove {
namespace {

using Json = nlohmann::json;

TEST(Subprotocol, IsTheFirstThatBothSpeak) {
  EXPECT_EQ(ChooseSubprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(ChooseSubprotocol("chat,foxglove.sdk.v1 ,\tfoxglove.websocket.v1"), "foxglove.sdk.v1");
  for (const char* none : {"", ",", " , ,", "chat", "foxglove.websocket.v2", "foxglove"}) {
    EXPECT_EQ(ChooseSubprotocol(none), "") << none;
  }
}

TEST(Status, IsJsonWhateverItQuotes) {
  const Json status = Json::parse(Status(Level::kError, "a\"b\xff\n"));
  EXPECT_EQ(status["op"], "status");
  EXPECT_EQ(status["level"], 2);
  EXPECT_EQ(status["message"], "a\"b\xef\xbf\xbd\n");
}

TEST(MessageHeader, HasOpcodeSubscriptionAndTimeLittleEndian) {
  const MessageHeader header = MakeMessageHeader(0x01020304, 0x1112131415161718);
  const MessageHeader expected = {1, 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11};
  EXPECT_EQ(header, expected);
}

TEST(Request, IsReadInEachOfItsKinds) {
  const Request subscribe = ParseRequest(
      R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":5}]})");
  ASSERT_EQ(subscribe.subscriptions.size(), 2u);
  EXPECT_EQ(subscribe.subscriptions[1].id, 4294967295u);
  EXPECT_EQ(subscribe.subscriptions[1].channel, 5u);
  EXPECT_THAT(ParseRequest(R"({"op":"unsubscribe","subscriptionIds":[0,1]})").ids,
              testing::ElementsAre(0u, 1u));
  const Request advertise = ParseRequest(
      R"({"op":"advertise","channels":[{"id":1,"topic":"/m","encoding":"json","schemaName":""}]})");
  EXPECT_EQ(advertise.channels.at(0).topic, "/m");
  EXPECT_EQ(ParseRequest(R"({"op":"unadvertise","channelIds":[7]})").ids.at(0), 7u);
  EXPECT_EQ(ParseRequest(R"({"op":"getParameters"})").op, "getParameters");
}

TEST(Request, IsRefusedWhereItLacksWhatItsKindNeeds) {
  for (const char* text :
       {"", "x", "null", "3", "[]", "{}", R"({"op":3})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":{}})", R"({"op":"subscribe","subscriptions":[3]})",
        R"({"op":"subscribe","subscriptions":[{"id":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
        R"({"op":"unsubscribe","subscriptionIds":["1"]})", R"({"op":"advertise","channels":[{}]})",
        R"({"op":"advertise","channels":[{"id":1,"topic":5,"encoding":"json"}]})",
        R"({"op":"unadvertise","channelIds":1})", "{\"op\":\"\xff\"}"}) {
    EXPECT_THROW(ParseRequest(text), Error) << text;
  }
  std::string many = R"({"op":"unsubscribe","subscriptionIds":[0)";
  for (int i = 0; i < 1000; ++i) many += ",1";
  EXPECT_THROW(ParseRequest(many + "]}"), Error);
  EXPECT_THROW(ParseRequest(std::string(60'000, '[')), Error);
}

TEST(ClientMessage, IsItsChannelAndItsPayload) {
  const std::uint8_t bytes[] = {1, 2, 1, 0, 0, '{', '}'};
  const ClientMessage message = ParseMessage(bytes);
  EXPECT_EQ(message.channel, 258u);
  EXPECT_EQ(message.payload, "{}");
  EXPECT_EQ(ParseMessage(std::span(bytes, 5)).payload, "");
  for (std::size_t n = 0; n < 5; ++n) EXPECT_THROW(ParseMessage(std::span(bytes, n)), Error) << n;
  const std::uint8_t other[] = {2, 2, 1, 0, 0};
  EXPECT_THROW(ParseMessage(other), Error);
}

}  // namespace
}  // namespace palpate::foxglove
