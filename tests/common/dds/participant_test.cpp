#include "common/dds/participant.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/ports.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "tests/common/dds/own_topic.h"
#include "tests/support/complaint.h"
#include "tests/support/roudi.h"

namespace palpate::dds {
namespace {

using testing::HasSubstr;

TEST(TransportName, HasThreeNamesAndIsUdpWhereThatIsAskedFor) {
  EXPECT_EQ(ParseTransport("auto"), Transport::kAuto);
  EXPECT_EQ(ParseTransport("shm"), Transport::kSharedMemory);
  EXPECT_EQ(ParseTransport("udp"), Transport::kUdp);
  EXPECT_THROW(ParseTransport("tcp"), UsageError);
  EXPECT_EQ(ChooseTransport(Transport::kUdp).transport, Transport::kUdp);
}

TEST(RouDiChoice, TakesSharedMemoryWhereRouDiAnswersAndNotWhereItsSocketIsStale) {
  RouDi roudi;
  EXPECT_EQ(ChooseTransport(Transport::kAuto).transport, Transport::kSharedMemory);
  EXPECT_EQ(ChooseTransport(Transport::kSharedMemory).transport, Transport::kSharedMemory);

  roudi.Kill();
  EXPECT_TRUE(WhyNoRouDi());
  const TransportChoice choice = ChooseTransport(Transport::kAuto);
  EXPECT_EQ(choice.transport, Transport::kUdp);
  EXPECT_THAT(choice.reason, HasSubstr("no RouDi listens at /tmp/roudi; start 'iox-roudi -c"));
  EXPECT_THAT(test::ComplaintOf([] { ChooseTransport(Transport::kSharedMemory); }),
              testing::AllOf(HasSubstr("--transport shm: no RouDi listens"),
                             HasSubstr("deploy/cyclonedds/roudi.toml' (same user")));
}

/// Listens where RouDi does while the object lives.
class ForeignSocket {
 public:
  ForeignSocket() : socket_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    unlink(kPath);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, kPath);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~ForeignSocket() {
    close(socket_);
    unlink(kPath);
  }
  static constexpr const char* kPath = "/tmp/roudi";

 private:
  int socket_;
};

TEST(RouDiChoice, TakesUdpWhereWhatListensIsNoRouDiOfThisUser) {
  RouDi roudi;  // for its lock, so that no other test's RouDi meets the foreign socket
  roudi.Kill();
  const ForeignSocket foreign;
  TransportChoice choice = ChooseTransport(Transport::kAuto);
  EXPECT_EQ(choice.transport, Transport::kUdp);
  EXPECT_THAT(choice.reason, HasSubstr("is no RouDi: it does not hold /tmp/iox-unique-roudi.lock"));
  EXPECT_THROW(ChooseTransport(Transport::kSharedMemory), Error);
  if (geteuid() != 0) GTEST_SKIP() << "only root can make another user's socket";
  ASSERT_EQ(chown(ForeignSocket::kPath, 1, 1), 0);
  choice = ChooseTransport(Transport::kAuto);
  EXPECT_EQ(choice.transport, Transport::kUdp);
  EXPECT_THAT(choice.reason, HasSubstr("another user's (uid 1)"));
}

/// Holds a UDP port while the object lives.
class TakenPort {
 public:
  explicit TakenPort(int port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    // A port that another program holds is taken just as well.
    EXPECT_TRUE(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 ||
                errno == EADDRINUSE)
        << errno;
  }
  TakenPort(TakenPort&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  ~TakenPort() {
    if (socket_ >= 0) close(socket_);
  }

 private:
  int socket_;
};

/// The error when a participant of the service domain cannot be made.
std::string Complaint(int domain, const Network& network = {}) {
  return test::ComplaintOf([&] { Participant::Service(domain, network); });
}

TEST(Participant, SaysThatADomainsPortsAreTaken) {
  const PortRange ports = PortsOf(ServiceDomainId(kDomain));
  std::vector<TakenPort> taken;
  for (int index = 0; index <= kMaxParticipantIndex; ++index) {
    taken.emplace_back(ports.first + 10 + 2 * index);  // its discovery: RTPS 2.3, 9.6.1.1
  }
  const std::string complaint = Complaint(kDomain);
  EXPECT_THAT(complaint, HasSubstr("--domain " + std::to_string(kDomain) + " (DDS domain " +
                                   std::to_string(ServiceDomainId(kDomain))));
  EXPECT_THAT(complaint, HasSubstr("of its UDP ports, " + std::to_string(ports.first) + " to "));
  EXPECT_THAT(complaint, HasSubstr("(the first is " + std::to_string(ports.first + 10) + ")"));
  EXPECT_THAT(complaint, HasSubstr("free on this host: --domain "));
  taken.clear();
  EXPECT_NO_THROW(Participant::Service(kDomain)) << "and leaves nothing behind";
}

TEST(Participant, SaysThatAnInterfaceIsNotThere) {
  const Participant other = Participant::Service(kDomain);  // so ports are not the reason
  EXPECT_THAT(Complaint(test::OwnDomain(), {.interface = "nowhere0", .peers = {}, .identity = {}}),
              HasSubstr("no interface 'nowhere0'"));
}

TEST(Participant, ComesUpWhereAConnectionSitsOnTheStandardsPortsOfItsDomain) {
  // By RTPS the ports are 7400 + 250 d, which for this domain are in the kernel's ephemeral range.
  constexpr int kFarDomain = 60;
  std::vector<TakenPort> taken;
  for (const int id : {LoopDomainId(kFarDomain), ServiceDomainId(kFarDomain)}) {
    taken.emplace_back(7400 + 250 * id);
    taken.emplace_back(7400 + 250 * id + 1);
  }
  EXPECT_NO_THROW(Participant::Loop(kFarDomain, kUdp));
  EXPECT_NO_THROW(Participant::Service(kFarDomain));
}

TEST(Participant, IsNotConfiguredByTheEnvironment) {
  setenv("CYCLONEDDS_URI", "<CycloneDDS><nonsense/></CycloneDDS>", 1);
  EXPECT_NO_THROW(Participant::Service(kDomain));
  unsetenv("CYCLONEDDS_URI");
}

TEST(Participant, SharesItsDomainWithinAProcessAndFreesItWithTheLast) {
  for (int i = 0; i < 3; ++i) {
    const Participant first = Participant::Loop(kDomain, kUdp);
    Participant second = Participant::Loop(kDomain, kUdp);
    const Participant third = std::move(second);
    EXPECT_NE(first.handle(), third.handle());
  }
}

TEST(Participant, RefusesADomainThatIsOpenWithAnotherTransport) {
  const Participant udp = Participant::Loop(kDomain, kUdp);
  EXPECT_THAT(test::ComplaintOf([] {
                Participant::Loop(kDomain, {Transport::kSharedMemory, ""});
              }),
              HasSubstr("another transport"));
}

TEST(Participant, KeepsLoopAndServiceDomainsApart) {
  const Participant loop = Participant::Loop(kDomain, kUdp);
  const Participant service = Participant::Service(kDomain);
  const Writer<wire::ToolState> writer(loop, "a/topic", Qos::kStream);
  EXPECT_TRUE(WriterDiscovered(loop, "a/topic"));
  EXPECT_FALSE(WriterDiscovered(service, "a/topic"));
  EXPECT_FALSE(service.shared_memory());
}

}  // namespace
}  // namespace palpate::dds
