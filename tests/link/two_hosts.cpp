#include "tests/link/two_hosts.h"

#include <sys/socket.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate::test {
namespace {

constexpr const char* kIp = "/bin/ip";
constexpr const char* kUnshare = "/usr/bin/unshare";
constexpr const char* kNsenter = "/usr/bin/nsenter";

void RunIp(const std::vector<std::string>& arguments) {
  Program ip(kIp, arguments);
  const int status = ip.Exit();
  if (status == 127) throw Error("there is no /bin/ip: install iproute2");
  if (status == 0) return;
  std::string command = "ip";
  for (const std::string& argument : arguments) command += " " + argument;
  throw Error("'" + command + "' fails: " + ip.Output());
}

}  // namespace

std::string TwoHosts::WhyNot() {
  for (const char* program : {kIp, kUnshare, kNsenter}) {
    if (access(program, X_OK) != 0) return std::string("there is no ") + program;
  }
  const int raw = socket(AF_PACKET, SOCK_RAW, 0);
  if (raw < 0) return "no packet socket (root, or CAP_NET_RAW)";
  close(raw);
  Program namespaces(kUnshare,
                     {"--net", kIp, "link", "add", "one", "type", "veth", "peer", "name", "other"});
  if (namespaces.Exit() == 0) return "";
  return "no network namespace with a pair of interfaces can be made (root, or CAP_SYS_ADMIN and "
         "CAP_NET_ADMIN): " +
         namespaces.Output();
}

TwoHosts::TwoHosts(const LinkConditions& each_way) {
  std::string end[2];
  for (int host = 0; host < 2; ++host) {
    holder_[host] = std::make_unique<Program>(
        kUnshare, std::vector<std::string>{"--net", "sh", "-c", "echo here; exec sleep infinity"});
    if (!holder_[host]->Says("here\n")) {
      throw Error("no network namespace can be made (root, or CAP_SYS_ADMIN): " +
                  holder_[host]->Output());
    }
    const std::string process = std::to_string(holder_[host]->id());
    end[host] = "pal" + process;
    RunIp({"link", "add", end[host], "type", "veth", "peer", "name", kLan, "netns", process});
    RunIp({"link", "set", end[host], "up"});
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"addr", "add", std::string(kAddress[host]) + "/24", "dev", kLan},
          {"link", "set", "lo", "up"},
          {"link", "set", kLan, "up"}}) {
      Program inside(kNsenter, [&] {
        std::vector<std::string> all{"--target", process, "--net", kIp};
        all.insert(all.end(), command.begin(), command.end());
        return all;
      }());
      if (inside.Exit() != 0) throw Error("a network namespace: " + inside.Output());
    }
  }
  wire_ = std::make_unique<BadWire>(end[0], end[1], 1, each_way);
}

std::unique_ptr<Program> TwoHosts::Start(int host, const std::string& file,
                                         const std::vector<std::string>& arguments) const {
  std::vector<std::string> all{"--target", std::to_string(holder_[host]->id()), "--net", file};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return std::make_unique<Program>(kNsenter, all);
}

}  // namespace palpate::test
