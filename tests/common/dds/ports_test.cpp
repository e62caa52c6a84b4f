#include "common/dds/ports.h"

#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <unistd.h>

#include "common/dds/participant.h"
#include "common/dds/topics.h"
#include "tests/common/dds/peer.h"
#include "tests/support/read_file.h"
#include "tests/support/test_domain.h"

namespace palpate::dds {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr PortRange kUsual{32768, 60999};

TEST(Ports, OfEveryDomainAreItsOwnAndBelowThoseThatTheKernelGivesToAnyone) {
  EXPECT_GE(PortsOf(LoopDomainId(0)).first, 1024);  // lower ports are for root alone
  for (int id = 0; id <= ServiceDomainId(kMaxDomain); ++id) {
    EXPECT_FALSE(PortsOf(id).Meets(kUsual)) << id;
    EXPECT_LT(PortsOf(id).last, 65536);
    EXPECT_EQ(PortsOf(id + 1).first, PortsOf(id).last + 1);
  }
  // The last process's data port is 11 + 2 i (RTPS 2.3, 9.6.1.1).
  EXPECT_LT(11 + 2 * kMaxParticipantIndex, kPortsPerDomain - 2);
  EXPECT_GE(kMaxParticipantIndex, 32 + 8) << "stations that a server admits, and who looks on";
}

TEST(Ports, AreThoseThatADomainTakes) {
  const int domain = test::OwnDomain();
  const PortRange ports = PortsOf(ServiceDomainId(domain));
  const Participant participant = Participant::Service(domain);
  const std::set<int> in_use = PortsInUse();
  std::set<int> taken;
  for (const int port : in_use) {
    if (ports.Has(port)) taken.insert(port - ports.first);
  }
  EXPECT_THAT(taken, testing::ElementsAre(0, 1, 10, 11));
}

const std::string kLimits = PALPATE_SOURCE_DIR "/server/limits.md";

TEST(Ports, AreDocumented) {
  const int both = 2 * kPortsPerDomain;
  const std::string said = std::to_string(kFirstPort) + " + " + std::to_string(both) +
                           " N and the " + std::to_string(both - 1) + " after it";
  EXPECT_NE(ReadWholeFile(kLimits).find(said), std::string::npos) << said;
}

TEST(Ports, LetAnotherToolInByTheSettingsThatAreDocumented) {
  const std::string limits = ReadWholeFile(kLimits), end = "</CycloneDDS>";
  const std::size_t from = limits.find("<CycloneDDS>"), to = limits.find(end);
  ASSERT_LT(from, to);
  ASSERT_NE(to, std::string::npos);
  const std::string settings = limits.substr(from, to - from) + end;

  const int domain = test::OwnDomain();
  Peer peer("bundle", domain, "tool", 1, "at-once");
  const auto id = static_cast<dds_domainid_t>(ServiceDomainId(domain));
  const dds_entity_t tool = dds_create_domain(id, settings.c_str());
  ASSERT_GT(tool, 0);
  const dds_entity_t participant = dds_create_participant(id, nullptr, nullptr);
  const dds_entity_t seen =
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  std::string topic;
  for (int i = 0; i < 10'000 && topic.empty(); ++i) {
    void* sample = nullptr;
    dds_sample_info_t info;
    if (dds_take(seen, &sample, &info, 1, 1) == 1) {
      topic = static_cast<const dds_builtintopic_endpoint_t*>(sample)->topic_name;
      dds_return_loan(seen, &sample, 1);
    } else {
      usleep(1000);
    }
  }
  dds_delete(tool);
  peer.Kill();
  EXPECT_EQ(topic, "tool");
}

TEST(Ports, AreReadAsTheKernelWritesThem) {
  std::istringstream udp(
      "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt\n"
      "  171: 00000000:1CE8 00000000:0000 07 00000000:00000000 00:00000000 00000000\n"
      " 1020: 00000000000000000000000001000000:0035 00000000000000000000000000000000:0000 07\n"
      "nonsense\n");
  EXPECT_EQ(PortsIn(udp), (std::set<int>{0x1ce8, 0x35}));
  std::istringstream range("1024\t65535\n"), none("");
  EXPECT_EQ(PortsOfAnyone(range).first, 1024);
  EXPECT_EQ(PortsOfAnyone(none).first, 32768);
}

TEST(Ports, ThatAreTakenAreNamedWithTheDomainsThatAreFree) {
  const PortRange ports = PortsOf(ServiceDomainId(1));
  const std::set<int> in_use{ports.first + 1, ports.first + 7, PortsOf(LoopDomainId(0)).first};
  const std::string why = WhyPortsFail(ServiceDomainId(1), in_use, kUsual);
  EXPECT_THAT(why, HasSubstr("7730 to 7839, other programs have 2 (the first is 7731)"));
  EXPECT_THAT(why, HasSubstr("free on this host: --domain 2, 3 or 4"));
  EXPECT_THAT(why, Not(HasSubstr("kernel")));
  EXPECT_EQ(WhyPortsFail(ServiceDomainId(7), in_use, kUsual), "");
}

TEST(Ports, ThatTheKernelGivesToAnyoneAreSaidToBe) {
  const std::set<int> in_use{PortsOf(9).first};
  EXPECT_THAT(WhyPortsFail(9, in_use, {1024, 65535}),
              HasSubstr("the kernel gives those from 1024 to 65535 to any connection"));
}

TEST(Ports, AreSaidToBeTakenEverywhereWhereTheyAre) {
  std::set<int> in_use;
  for (int domain = 0; domain <= kMaxDomain; ++domain) {
    in_use.insert(PortsOf(LoopDomainId(domain)).first);
  }
  EXPECT_THAT(WhyPortsFail(0, in_use, kUsual), HasSubstr("no other --domain is free"));
}

}  // namespace
}  // namespace palpate::dds
