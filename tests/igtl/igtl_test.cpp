#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <igtlClientSocket.h>
#include <igtlMessageHeader.h>
#include <igtlSensorMessage.h>
#include <igtlTransformMessage.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/igtl/igtl_messages.h"
#include "client/igtl/igtl_server.h"
#include "common/error.h"

namespace palpate::test {
namespace {

/// A message as a client with OpenIGTLink's library reads it.
struct Received {
  igtl::MessageHeader::Pointer header;
  std::vector<std::uint8_t> body;
};

std::vector<Received> ReadAll(const std::vector<std::uint8_t>& bytes) {
  std::vector<Received> all;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto header = igtl::MessageHeader::New();
    header->InitPack();
    const auto head = static_cast<std::size_t>(header->GetPackSize());
    if (at + head > bytes.size()) break;
    std::memcpy(header->GetPackPointer(), bytes.data() + at, head);
    EXPECT_TRUE(header->Unpack(1) & igtl::MessageHeader::UNPACK_HEADER);
    at += head;
    const auto size = static_cast<std::size_t>(header->GetBodySizeToRead());
    EXPECT_LE(at + size, bytes.size());
    if (at + size > bytes.size()) break;
    all.push_back({header, {bytes.data() + at, bytes.data() + at + size}});
    at += size;
  }
  return all;
}

template <class Message>
typename Message::Pointer Unpack(Received& received) {
  typename Message::Pointer message = Message::New();
  message->SetMessageHeader(received.header);
  message->AllocatePack();
  EXPECT_EQ(static_cast<std::size_t>(message->GetPackBodySize()), received.body.size());
  std::memcpy(message->GetPackBodyPointer(), received.body.data(), received.body.size());
  EXPECT_TRUE(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) << "its checksum is wrong";
  return message;
}

wire::ToolState Tool() {
  wire::ToolState tool{};
  wire::FromText("hand", tool.station);
  // A quarter turn about the scene's y, which points up.
  wire::FromPose({Vec3(0.001, 0.002, 0.003), Quat(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()))},
                 tool.graphic_position_m, tool.graphic_orientation_wxyz);
  wire::FromVec3({1, 2, 3}, tool.force_N);
  wire::FromVec3({0.1, 0.2, 0.3}, tool.torque_Nm);
  return tool;
}

TEST(IgtlMessages, AreATransformInMillimetresAndTwoSensorsInRas) {
  auto all = ReadAll(IgtlMessages(Tool(), 1'700'000'000'500'000'000));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_STREQ(all[0].header->GetDeviceName(), "hand");
  EXPECT_STREQ(all[1].header->GetDeviceName(), "hand_force");
  EXPECT_STREQ(all[2].header->GetDeviceName(), "hand_torque");

  igtl::Matrix4x4 m;
  Unpack<igtl::TransformMessage>(all[0])->GetMatrix(m);
  // Right is -x, anterior is z, superior is y.
  EXPECT_FLOAT_EQ(m[0][3], -1.0f);
  EXPECT_FLOAT_EQ(m[1][3], 3.0f);
  EXPECT_FLOAT_EQ(m[2][3], 2.0f);
  // The tool's x axis, once the scene's, now points to -z: posterior.  Its y axis stays up.
  EXPECT_NEAR(m[1][0], -1.0f, 1e-6);
  EXPECT_NEAR(m[2][1], 1.0f, 1e-6);
  // It is a rotation: the third column is the cross product of the first two.
  const Vec3 x(m[0][0], m[1][0], m[2][0]), y(m[0][1], m[1][1], m[2][1]),
      z(m[0][2], m[1][2], m[2][2]);
  EXPECT_LT((x.cross(y) - z).norm(), 1e-6);

  const auto force = Unpack<igtl::SensorMessage>(all[1]);
  ASSERT_EQ(force->GetLength(), 3u);
  EXPECT_EQ(force->GetValue(0), -1.0);
  EXPECT_EQ(force->GetValue(1), 3.0);
  EXPECT_EQ(force->GetValue(2), 2.0);
  const auto torque = Unpack<igtl::SensorMessage>(all[2]);
  EXPECT_EQ(torque->GetValue(1), 0.3);
  EXPECT_NE(force->GetUnit(), torque->GetUnit());
  EXPECT_NE(force->GetUnit(), 0u);
}

TEST(IgtlMessages, AreNoneOfAPoseThatIsNotFinite) {
  wire::ToolState tool = Tool();
  tool.graphic_position_m[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(IgtlMessages(tool, 0).empty());
}

TEST(IgtlMessages, TellLongNamesApartThatBeginAlike) {
  const std::string a = IgtlName("a_very_long_name_of_a_station_01"),
                    b = IgtlName("a_very_long_name_of_a_station_02");
  EXPECT_NE(a, b);
  EXPECT_LE((a + "_torque").size(), 20u);
}

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// A client that may send anything.
class RawClient {
 public:
  /// @param host  last byte of its address, 127.0.0.x.
  explicit RawClient(int port, std::uint32_t host = 1) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl((INADDR_LOOPBACK & ~0xffu) | host);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&place), sizeof place), 0);
    place.sin_port = htons(static_cast<std::uint16_t>(port));
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&place), sizeof place), 0);
  }
  ~RawClient() { close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;
  /// False if the server has closed the connection.
  bool is_connected() const {
    char byte;
    return recv(socket_, &byte, 1, MSG_DONTWAIT) != 0;
  }
  int socket_;
};

std::vector<std::uint8_t> Frame(std::size_t size) {
  std::vector<std::uint8_t> frame(size);
  std::iota(frame.begin(), frame.end(), std::uint8_t{1});
  return frame;
}

TEST(IgtlServer, SendsToAClientOfTheLibrary) {
  IgtlServer server("127.0.0.1", 0);
  const auto client = igtl::ClientSocket::New();
  ASSERT_EQ(client->ConnectToServer("127.0.0.1", server.port()), 0);
  server.Poll(0);
  ASSERT_EQ(server.clients(), 1u);
  const auto frame = Frame(500);
  server.Send(frame, 0);
  std::vector<std::uint8_t> got(frame.size());
  ASSERT_EQ(client->Receive(got.data(), static_cast<int>(got.size())), 500);
  EXPECT_EQ(got, frame);
  client->CloseSocket();
  server.Poll(1);
  EXPECT_EQ(server.clients(), 0u);
}

TEST(IgtlServer, IsHeldUpByNobodyWhoTakesNothingAndGivesOthersWholeMessages) {
  IgtlServer server("127.0.0.1", 0);
  RawClient dead(server.port()), honest(server.port());
  server.Poll(0);
  ASSERT_EQ(server.clients(), 2u);
  const auto frame = Frame(100'000);
  std::vector<std::uint8_t> got(frame.size());
  std::int64_t now_ns = 0;
  int frames = 0;
  for (; server.clients() == 2 && frames < 1000; ++frames) {
    now_ns += kSecond_ns / 10;
    server.Send(frame, now_ns);
    // Loopback delivers what is sent, but in parts.
    for (std::size_t at = 0; at < got.size();) {
      const ssize_t n = recv(honest.socket_, got.data() + at, got.size() - at, MSG_DONTWAIT);
      if (n > 0) {
        at += static_cast<std::size_t>(n);
      } else {
        server.Send({}, now_ns);
      }
    }
    ASSERT_EQ(got, frame);
  }
  EXPECT_EQ(server.clients(), 1u) << "the dead one is still there";
  EXPECT_EQ(server.counts().closed, 1u);
  EXPECT_GT(server.counts().passed_over, 0u);
}

TEST(IgtlServer, HeedsNothingThatItIsSent) {
  IgtlServer server("127.0.0.1", 0);
  RawClient hostile(server.port());
  server.Poll(0);
  std::vector<std::uint8_t> noise(1 << 20);
  std::uint32_t seed = 1;
  for (auto& byte : noise)
    byte = static_cast<std::uint8_t>((seed = seed * 1664525 + 1013904223) >> 24);
  std::size_t sent = 0;
  for (int i = 0; i < 100; ++i) {
    const ssize_t n =
        send(hostile.socket_, noise.data(), noise.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) sent += static_cast<std::size_t>(n);
    server.Poll(i);
    const auto frame = Frame(64);
    server.Send(frame, i);
    std::vector<std::uint8_t> got(frame.size());
    ASSERT_EQ(recv(hostile.socket_, got.data(), got.size(), MSG_WAITALL), 64);
    ASSERT_EQ(got, frame);
  }
  EXPECT_GT(sent, noise.size());
  EXPECT_EQ(server.clients(), 1u);
}

TEST(IgtlServer, HasRoomForSoManyOfWhomTheOldestGivesWayToANewcomerOfItsAddress) {
  IgtlServer server("127.0.0.1", 0);
  std::vector<std::unique_ptr<RawClient>> clients;
  for (std::size_t i = 0; i < IgtlServer::kMostClients + 3; ++i) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    server.Poll(0);
  }
  EXPECT_EQ(server.clients(), IgtlServer::kMostClients);
  EXPECT_EQ(server.counts().displaced, 3u);
  for (std::size_t i = 0; i < clients.size(); ++i) EXPECT_EQ(clients[i]->is_connected(), i >= 3);
}

TEST(IgtlServer, IsHeldByNoAddressAgainstAnother) {
  IgtlServer server("127.0.0.1", 0);
  std::vector<std::unique_ptr<RawClient>> idle;
  const auto come = [&](std::uint32_t host) {
    idle.push_back(std::make_unique<RawClient>(server.port(), host));
    server.Poll(0);
  };
  for (std::size_t i = 0; i < IgtlServer::kMostClients; ++i) come(2);
  const RawClient slicer(server.port(), 3);
  server.Poll(0);
  EXPECT_TRUE(slicer.is_connected());
  for (std::size_t i = 0; i < 2 * IgtlServer::kMostClients; ++i) come(2);
  EXPECT_TRUE(slicer.is_connected()) << "a flood is its own address's affair";
  EXPECT_EQ(server.clients(), IgtlServer::kMostClients);
  EXPECT_EQ(server.counts().refused, 0u);
  // There are places for sixteen addresses, one each: the seventeenth has to wait.
  for (std::uint32_t host = 4; host < 4 + IgtlServer::kMostClients; ++host) come(host);
  EXPECT_TRUE(slicer.is_connected());
  EXPECT_EQ(server.counts().refused, 2u);
}

TEST(IgtlServer, SaysWhichAddressItCannotHave) {
  IgtlServer server("127.0.0.1", 0);
  EXPECT_THROW(IgtlServer("127.0.0.1", server.port()), Error);
  EXPECT_THROW(IgtlServer("localhost", 0), UsageError);
}

}  // namespace
}  // namespace palpate::test
