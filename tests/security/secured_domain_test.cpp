// A secured domain as in a lab: identities made by the script, the real programs, and people who
// try what they may not.
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "common/dds/participant.h"
#include "common/dds/ports.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "tests/security/authority.h"
#include "tests/security/eavesdropper.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
namespace fs = std::filesystem;

const int kDomain = OwnDomain();
const std::string kNumber = std::to_string(kDomain);

const Authority& Lab() {
  static const Authority authority("lab");
  return authority;
}
std::string IdentityOf(const std::string& role, const std::string& name) {
  static std::map<std::string, std::string> made;
  std::string& identity = made[name];
  if (identity.empty()) identity = Lab().Add(role, name);
  return identity;
}

Program RunProgram(const std::string& name, std::vector<std::string> arguments,
                   const std::string& identity) {
  arguments.insert(arguments.end(), {"--domain", kNumber});
  if (!identity.empty()) arguments.insert(arguments.end(), {"--identity", identity});
  return Program(OwnFolder() + "/" + name, std::move(arguments));
}

/// The server, and a station that drives its cube, both with identities.
struct SecuredLab {
  Program server =
      RunProgram("palpate-server", {"cube", "--realtime", "off"}, IdentityOf("server", "srv"));
  bool serves = server.Says("ready", 120.0);
  Program station = RunProgram(
      "palpate-station",
      {"--device", "simulated", "--scene", "cube", "--id", "left", "--loop", "--realtime", "off"},
      IdentityOf("station", "left"));
};

/// Runs a station for 4 s; without an identity if none is given.
std::unique_ptr<Program> Rogue(const std::string& identity, const std::string& does,
                               const std::string& topic) {
  return std::make_unique<Program>(
      OwnFolder() + "/rogue",
      std::vector<std::string>{kNumber, identity.empty() ? "-" : identity, "4", does, topic});
}
std::string SaidInTheEnd(Program& program) {
  program.Exit(60.0);
  return program.Output();
}

TEST(SecuredDomain, LetsAStationFeelAViewerLookAndARecorderRecord) {
  SecuredLab lab;
  ASSERT_TRUE(lab.serves) << lab.server.Output();
  EXPECT_THAT(lab.server.Output(), HasSubstr("UDP (secured"));
  EXPECT_TRUE(lab.station.Says("session: tool", 60.0)) << lab.station.Output();
  EXPECT_TRUE(lab.server.Says("left", 20.0));
  const fs::path file =
      fs::temp_directory_path() / ("palpate_secured_" + std::to_string(getpid()) + ".mcap");
  Program recorder =
      RunProgram("palpate-record", {"-o", file, "--for", "4"}, IdentityOf("recorder", "rec"));
  const auto viewer = Rogue(IdentityOf("viewer", "class"), "read", "palpate/tool_state");
  EXPECT_EQ(recorder.Exit(60.0), 0) << recorder.Output();
  EXPECT_THAT(SaidInTheEnd(*viewer), Not(HasSubstr("heard 0")));
  Program info(OwnFolder() + "/palpate-record", {"info", file});
  info.Exit(60.0);
  EXPECT_THAT(info.Output(), HasSubstr("palpate/left/"));
  fs::remove(file);
}

TEST(SecuredDomain, IsPutUnderLoadByWhoMayDoSo) {
  Program server =
      RunProgram("palpate-server", {"cube", "--realtime", "off"}, IdentityOf("server", "srv"));
  ASSERT_TRUE(server.Says("ready", 120.0)) << server.Output();
  const std::vector<std::string> arguments{"--seconds", "1",     "--realtime", "off",
                                           "--name",    "crowd", "--json",     "-"};
  Program load = RunProgram("palpate-load", arguments, IdentityOf("load", "crowd"));
  EXPECT_EQ(load.Exit(60.0), 0) << load.Output();
  EXPECT_THAT(load.Output(), testing::ContainsRegex("\"achieved_hz\": ?[1-9]"));
  EXPECT_TRUE(server.Says("station crowd_1: active", 1.0)) << server.Output();
  Program stranger = RunProgram("palpate-load", arguments, IdentityOf("load", "others"));
  EXPECT_EQ(stranger.Exit(60.0), 1) << stranger.Output();
  EXPECT_THAT(stranger.Output(), HasSubstr("the role of this --identity"));
  EXPECT_THAT(stranger.Output(),
              HasSubstr("made for another station than 'crowd_1': give the --id"));
}

TEST(SecuredDomain, NeitherHearsNorIsHeardByWhoHasNoIdentityOrAnotherAuthoritys) {
  const Authority elsewhere("elsewhere");
  SecuredLab lab;
  ASSERT_TRUE(lab.serves) << lab.server.Output();
  ASSERT_TRUE(lab.station.Says("session: tool", 60.0)) << lab.station.Output();
  std::vector<std::unique_ptr<Program>> readers, writers;
  for (const std::string& identity : {std::string(), elsewhere.Add("gateway", "gate")}) {
    for (const std::string topic : {"palpate/tool_state", "palpate/session_state"}) {
      readers.push_back(Rogue(identity, "read", topic));
    }
    writers.push_back(Rogue(identity, "write", "palpate/operate_request"));
  }
  for (const auto& reader : readers) {
    EXPECT_THAT(SaidInTheEnd(*reader), HasSubstr("matched 0\nheard 0"));
  }
  for (const auto& writer : writers) EXPECT_THAT(SaidInTheEnd(*writer), HasSubstr("matched 0"));
  lab.server.Output();
  // An identity of another authority is reported; without one nobody is a participant of this
  // domain.
  EXPECT_TRUE(lab.server.Says("", 0.1));
  EXPECT_THAT(lab.server.Output(), HasSubstr("DDS: ")) << "a refusal that nobody logged";
}

/// A teacher's wishes and a hand's forces, written and read by those who may.
struct Talk {
  std::string topic, from_role, from, to_role, to;
};

TEST(SecuredDomain, HearsNothingAgainFromWhoHasNoIdentity) {
  const int first_port = dds::PortsOf(dds::LoopDomainId(kDomain)).first;
  const int last_port = dds::PortsOf(dds::ServiceDomainId(kDomain)).last;
  if (!Eavesdropper(first_port, last_port).hears()) {
    GTEST_SKIP() << "no raw socket (root, or CAP_NET_RAW)";
  }
  for (const Talk& talk :
       {Talk{"palpate/operate_request", "gateway", "gate", "server", "srv"},
        Talk{"palpate/left/00000000000000ab/wrench", "server", "srv", "station", "left"}}) {
    for (const bool secured : {false, true}) {
      const auto run = [&](const std::string& role, const std::string& name, const char* does) {
        const std::string identity = secured ? IdentityOf(role, name) : "-";
        return Program(OwnFolder() + "/rogue", {kNumber, identity, "60", does, talk.topic});
      };
      Program reader = run(talk.to_role, talk.to, "read");
      Program writer = run(talk.from_role, talk.from, "write");
      ASSERT_TRUE(reader.Says("hears 100\n", 30.0)) << reader.Output();
      EXPECT_EQ(Eavesdropper(first_port, last_port).SendAgain(50), 50);
      if (secured) {
        EXPECT_TRUE(reader.Says("hears 200\n")) << talk.topic << ": silenced\n" << reader.Output();
        EXPECT_THAT(reader.Output(), Not(HasSubstr("again"))) << talk.topic;
      } else {
        EXPECT_TRUE(reader.Says("again\n")) << "the attack is none";
      }
    }
  }
}

TEST(SecuredDomain, AllowsEachRoleItsOwnWordsAndNoMore) {
  struct Attempt {
    std::string does, topic;
    bool allowed;
  };
  struct Role {
    std::string role, name;
    std::vector<Attempt> attempts;
  };
  const std::string run = "/00000000000000ab/";
  for (const Role& role : std::vector<Role>{
           {"station",
            "left",
            {{"write", "palpate/left" + run + "pose", true},
             {"read", "palpate/left" + run + "wrench", true},
             {"write", "palpate/right" + run + "pose", false},
             {"write", "palpate/left2" + run + "pose", false},
             {"write", "palpate/left" + run + "wrench", false},
             {"read", "palpate/right" + run + "wrench", false},
             {"read", "palpate/right" + run + "pose", false},
             {"write", "palpate/session_state", false},
             {"write", "palpate/operate_request", false},
             {"read", "palpate/tool_state", false}}},
           {"viewer",
            "class",
            {{"read", "palpate/tool_state", true},
             {"write", "palpate/tool_state", false},
             {"write", "palpate/left" + run + "pose", false},
             {"write", "palpate/session_request", false},
             {"write", "palpate/operate_request", false},
             {"read", "palpate/left" + run + "pose", false}}},
           {"gateway",
            "gate",
            {{"write", "palpate/operate_request", true},
             {"write", "palpate/mouse_1a2b_1" + run + "pose", true},
             {"write", "palpate/left" + run + "pose", false},
             {"write", "palpate/session_state", false}}},
           {"load",
            "l",
            {{"write", "palpate/l_1" + run + "pose", true},
             {"write", "palpate/l_32" + run + "pose", true},
             {"read", "palpate/l_32" + run + "wrench", true},
             {"write", "palpate/l_eft" + run + "pose", false},
             {"write", "palpate/l_1eft" + run + "pose", false},
             {"read", "palpate/l_eft" + run + "wrench", false}}},
           {"recorder",
            "rec",
            {{"read", "palpate/left" + run + "pose", true},
             {"write", "palpate/left" + run + "pose", false},
             {"write", "palpate/session_request", false}}},
           {"bridge",
            "ros",
            {{"read", "palpate/left" + run + "pose", true},
             {"read", "palpate/left" + run + "wrench", true},
             {"read", "palpate/session_state", true},
             {"read", "palpate/tool_state", true},
             {"write", "palpate/operate_request", true},
             {"read", "palpate/session_request", false},
             {"write", "palpate/session_request", false},
             {"write", "palpate/session_state", false},
             {"write", "palpate/tool_state", false},
             {"write", "palpate/left" + run + "pose", false},
             {"write", "palpate/left" + run + "wrench", false}}},
           {"server",
            "srv",
            {{"write", "palpate/left" + run + "wrench", true},
             {"write", "palpate/left" + run + "pose", false},
             {"write", "palpate/session_request", false}}},
       }) {
    SCOPED_TRACE(role.role);
    std::vector<std::string> arguments{kNumber, IdentityOf(role.role, role.name), "0.01"};
    for (const Attempt& attempt : role.attempts) {
      arguments.insert(arguments.end(), {attempt.does, attempt.topic});
    }
    Program rogue(OwnFolder() + "/rogue", arguments);
    rogue.Exit(60.0);
    std::istringstream said(rogue.Output());
    for (const Attempt& attempt : role.attempts) {
      std::string line;
      std::getline(said, line);
      if (attempt.allowed) {
        EXPECT_THAT(line, HasSubstr("matched")) << attempt.does << " " << attempt.topic;
        if (attempt.does == "read") std::getline(said, line);  // heard
      } else {
        EXPECT_THAT(line, StartsWith("not allowed: ")) << attempt.does << " " << attempt.topic;
        EXPECT_THAT(line, HasSubstr("Not Allowed By Security; the role of this --identity"));
      }
    }
  }
}

/// What a client receives at a TCP port of this host within a while; at most 64 kB.
std::size_t BytesAt(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{10, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::vector<char> bytes(65536);
  ssize_t n = -1;
  if (connect(fd, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0) {
    n = recv(fd, bytes.data(), bytes.size(), 0);
  }
  close(fd);
  return n > 0 ? static_cast<std::size_t>(n) : 0;
}

TEST(SecuredDomain, LetsABridgeBringAStationToRosAndNobodyInItsPlace) {
  SecuredLab lab;
  ASSERT_TRUE(lab.serves) << lab.server.Output();
  ASSERT_TRUE(lab.station.Says("session: tool", 60.0)) << lab.station.Output();
  // ROS counts 250 ports to a domain: 29,900 and on are none of a test's own.
  const std::vector<std::string> ros = {"--ros-domain", "90", "--for", "8"};
  std::vector<std::string> looking = ros;
  looking.push_back("--read-only");
  Program bridge = RunProgram("palpate-crtk", ros, IdentityOf("bridge", "ros"));
  Program looker = RunProgram("palpate-crtk", looking, IdentityOf("recorder", "rec"));
  for (Program* program : {&bridge, &looker}) {
    EXPECT_EQ(program->Exit(60.0), 0) << program->Output();
    EXPECT_THAT(program->Output(), HasSubstr("station left: /left/measured_cp"));
    EXPECT_THAT(program->Output(),
                ContainsRegex("station left: [1-9][0-9]+ poses, [1-9][0-9]+ wr"));
  }
  // Who may not write guides and wishes, and who may not hear the loop.
  Program recorder = RunProgram("palpate-crtk", ros, IdentityOf("recorder", "rec"));
  EXPECT_EQ(recorder.Exit(60.0), 1);
  EXPECT_THAT(recorder.Output(), HasSubstr("palpate/guide"));
  EXPECT_THAT(recorder.Output(), HasSubstr("the role of this --identity"));
  Program station = RunProgram("palpate-crtk", looking, IdentityOf("station", "left"));
  EXPECT_EQ(station.Exit(60.0), 1) << station.Output();
  EXPECT_THAT(station.Output(), HasSubstr("the role of this --identity"));
}

TEST(SecuredDomain, LetsAViewerOrABridgeTellSlicerOfToolsAndNoStation) {
  SecuredLab lab;
  ASSERT_TRUE(lab.serves) << lab.server.Output();
  ASSERT_TRUE(lab.station.Says("session: tool", 60.0)) << lab.station.Output();
  for (const auto& [role, name] :
       std::vector<std::pair<std::string, std::string>>{{"viewer", "class"}, {"bridge", "ros"}}) {
    Program igtl = RunProgram("palpate-igtl", {"--port", "0"}, IdentityOf(role, name));
    ASSERT_TRUE(igtl.Says("ready: OpenIGTLink at 127.0.0.1:", 60.0)) << igtl.Output();
    ASSERT_TRUE(igtl.Says("\n"));
    const std::string& said = igtl.Output();
    EXPECT_GT(BytesAt(std::stoi(said.substr(said.find("127.0.0.1:") + 10))), 100u) << role;
  }
  Program station = RunProgram("palpate-igtl", {"--port", "0"}, IdentityOf("station", "left"));
  EXPECT_EQ(station.Exit(60.0), 1) << station.Output();
  EXPECT_THAT(station.Output(), HasSubstr("palpate/tool_state"));
  EXPECT_THAT(station.Output(), HasSubstr("the role of this --identity"));
}

TEST(SecuredDomain, TakesNoIdentityThatSomebodyHasChanged) {
  const fs::path identity = Lab().Add("viewer", "changed");
  std::ifstream in(identity / "permissions.p7s");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t at = text.find("palpate/tool_state");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 18, "palpate/all_states");
  std::ofstream(identity / "permissions.p7s") << text;
  EXPECT_THAT(SaidInTheEnd(*Rogue(identity, "read", "palpate/tool_state")),
              HasSubstr("not allowed: "));
}

TEST(Identity, IsNotForSharedMemory) {
  dds::Network network;
  network.identity = "/tmp";
  EXPECT_EQ(dds::ChooseTransport(dds::Transport::kAuto, network).transport, dds::Transport::kUdp);
  EXPECT_THROW(dds::ChooseTransport(dds::Transport::kSharedMemory, network), Error);
}

TEST(IdentitiesScript, OverwritesNothingAndNamesWhatItDoesNotKnow) {
  Lab().Add("viewer", "once");
  const std::string folder = fs::path(IdentityOf("server", "srv")).parent_path().parent_path();
  Authority::Script({"add", folder, "viewer", "once"}, 1);
  Authority::Script({"new", folder}, 1);
  Authority::Script({"add", folder, "king", "k"}, 2);
  Authority::Script({"add", folder, "viewer", "../../x"}, 2);
  Authority::Script({"add", folder, "viewer", "<x/>"}, 2);
  // Stations driven by another identity.
  Authority::Script({"add", folder, "load", "many"});
  Authority::Script({"add", folder, "station", "many_7"}, 1);
  Authority::Script({"add", folder, "station", "many_seven"});
  Authority::Script({"add", folder, "station", "few_1"});
  Authority::Script({"add", folder, "load", "few"}, 1);
  Authority::Script({"add", folder, "station", "mouse_1a2b_1"}, 2);
  Authority::Script({"--help"});
}

}  // namespace
}  // namespace palpate::test
