#include "common/dds/participant.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "tests/common/dds/roudi.h"

namespace palpate::dds {
namespace {

using testing::HasSubstr;

constexpr int kDomain = 90;
const TransportChoice kUdp{Transport::kUdp, ""};

TEST(ParseTransport, KnowsThreeNames) {
  EXPECT_EQ(ParseTransport("auto"), Transport::kAuto);
  EXPECT_EQ(ParseTransport("shm"), Transport::kSharedMemory);
  EXPECT_EQ(ParseTransport("udp"), Transport::kUdp);
  EXPECT_THROW(ParseTransport("tcp"), UsageError);
}

TEST(ChooseTransport, TakesUdpWhereItIsAskedFor) {
  EXPECT_EQ(ChooseTransport(Transport::kUdp).transport, Transport::kUdp);
}

TEST(RouDiChoice, TakesSharedMemoryWhereRouDiAnswersAndNotWhereItsSocketIsStale) {
  RouDi roudi;
  EXPECT_EQ(ChooseTransport(Transport::kAuto).transport, Transport::kSharedMemory);
  EXPECT_EQ(ChooseTransport(Transport::kSharedMemory).transport, Transport::kSharedMemory);

  roudi.Kill();
  EXPECT_FALSE(RouDiAnswers());
  const TransportChoice choice = ChooseTransport(Transport::kAuto);
  EXPECT_EQ(choice.transport, Transport::kUdp);
  EXPECT_THAT(choice.reason, HasSubstr("no RouDi: start 'iox-roudi -c"));
  try {
    ChooseTransport(Transport::kSharedMemory);
    FAIL() << "shared memory without RouDi";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("--transport shm: no RouDi"));
    EXPECT_THAT(e.what(), HasSubstr("iox-roudi -c deploy/cyclonedds/roudi.toml"));
  }
}

TEST(Participant, SaysThatADomainsPortsAreTaken) {
  constexpr int kCrowded = 89;
  std::vector<int> sockets;
  for (int index = 0; index <= 100; ++index) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    // The port of a participant's discovery: RTPS 2.3, 9.6.1.1.
    address.sin_port =
        htons(static_cast<std::uint16_t>(7400 + 250 * ServiceDomainId(kCrowded) + 10 + 2 * index));
    sockets.push_back(socket(AF_INET, SOCK_DGRAM, 0));
    // A port that is another program's already is taken just as well.
    const bool taken =
        bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 ||
        errno == EADDRINUSE;
    EXPECT_TRUE(taken) << errno;
  }
  try {
    Participant::Service(kCrowded);
    ADD_FAILURE() << "made without a port";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("ports"));
    EXPECT_THAT(e.what(), HasSubstr("--domain"));
  }
  for (const int socket : sockets) close(socket);
  EXPECT_NO_THROW(Participant::Service(kCrowded)) << "and leaves nothing behind";
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
  try {
    Participant::Loop(kDomain, {Transport::kSharedMemory, ""});
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("another transport"));
  }
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
