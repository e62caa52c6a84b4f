#include <csignal>
#include <fstream>
#include <optional>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "tests/faults/faults.h"

namespace palpate::faults {
namespace {

/// RouDi's socket and lock lie in /tmp, so /tmp is replaced as well; what the programs need of the
/// old one is mounted at its old place, with everything beside it.  $1: size of /dev/shm; then the
/// paths of what they need.
constexpr const char* kMounts = R"(
set -e
mount --make-rprivate /
mount -t tmpfs -o "size=$1" palpate_test /dev/shm
shift
mount -t tmpfs palpate_test /mnt
for path; do
  case $path in /tmp/*)
    path=${path#/tmp/}
    mkdir -p "/mnt/${path%%/*}"
    mount --rbind "/tmp/${path%%/*}" "/mnt/${path%%/*}" ;;
  esac
done
mount --rbind /mnt /tmp
umount -l /mnt
echo mounted
exec sleep 3600
)";

/// A mount namespace with a /dev/shm and a /tmp of its own, in which a laboratory's programs run.
class OwnMemory {
 public:
  OwnMemory(Lab& lab, const std::string& size)
      : holder_("/usr/bin/unshare", Namespaces({"sh", "-c", kMounts, "sh", size, PALPATE_SOURCE_DIR,
                                                test::OwnFolder(), lab.folder()})) {
    if (!holder_.Says("mounted", 10.0)) return;
    words_ = {"/usr/bin/nsenter", "-t", std::to_string(holder_.id()), "-m"};
    if (geteuid() != 0) words_->insert(words_->end(), {"-U", "--preserve-credentials"});
    words_->push_back("--");
    for (const char* program :
         {"palpate-server", "palpate-station", "palpate-viewer", "palpate-record"}) {
      lab.StartWith(program, *words_);
    }
  }

  bool is_there() const { return words_.has_value(); }
  Finding Skipped() {
    const std::string& said = holder_.Output();
    return {"(a /dev/shm of its own)",
            "skipped: this machine gives no mount namespace: " + said.substr(0, said.find('\n')),
            true};
  }
  test::Program Run(const std::vector<std::string>& command) const {
    std::vector<std::string> arguments(words_->begin() + 1, words_->end());
    arguments.insert(arguments.end(), command.begin(), command.end());
    return test::Program(words_->front(), arguments);
  }
  test::Program RouDi() const {
    return Run({"/usr/bin/iox-roudi", "-c", PALPATE_SOURCE_DIR "/deploy/cyclonedds/roudi.toml"});
  }
  /// Fills the memory that is left; returns how much that was [bytes].
  std::size_t Fill() const {
    const std::string block(65536, 'x');
    std::ofstream file(fmt::format("/proc/{}/root/dev/shm/full", holder_.id()));
    std::size_t bytes = 0;
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
      bytes += block.size();
    }
    return bytes;
  }

 private:
  static std::vector<std::string> Namespaces(std::vector<std::string> command) {
    std::vector<std::string> words{"-m"};
    if (geteuid() != 0) words.push_back("-r");
    words.insert(words.end(), command.begin(), command.end());
    return words;
  }

  test::Program holder_;
  std::optional<std::vector<std::string>> words_;
};

/// Checks that every program serves; if one does not come up, Lab throws with its output.
void AllServe(Lab& lab, Findings& findings) {
  lab.StartServer();
  lab.StartGateway();
  lab.StartRecorder();
  lab.StartStation();
  findings.push_back(LoopRuns(lab));
  findings.push_back(Shows("the gateway shows the scene", lab));
  findings.push_back(EndsInOrder("the recorder", *lab.recorder));
}

}  // namespace

Findings SharedMemoryTooSmall(int domain) {
  Lab lab(domain, "auto");
  OwnMemory memory(lab, "64k");
  if (!memory.is_there()) return {memory.Skipped()};
  memory.Fill();
  Findings findings;
  test::Program roudi = memory.RouDi();
  const int roudi_exit = roudi.Exit(30.0);
  findings.push_back(
      {"RouDi ends and says that memory is short", fmt::format("exit status {}", roudi_exit),
       roudi_exit != 0 && roudi.Output().find("requires more memory") != std::string::npos});
  test::Program doctor = memory.Run({test::OwnFolder() + "/palpate-doctor"});
  doctor.Exit(60.0);
  const bool names_it = doctor.Output().find("remount,size=256m /dev/shm") != std::string::npos;
  findings.push_back({"palpate-doctor names /dev/shm, and the remedy",
                      names_it ? "it does" : doctor.Output(), names_it});
  test::Program server =
      memory.Run({test::OwnFolder() + "/palpate-server", "cube", "--realtime", "off", "--transport",
                  "shm", "--domain", std::to_string(domain)});
  const int server_exit = server.Exit(30.0);
  findings.push_back(
      {"a server that is to use shared memory says what it lacks",
       fmt::format("exit status {}", server_exit),
       server_exit == 1 && server.Output().find("start 'iox-roudi") != std::string::npos});
  AllServe(lab, findings);
  findings.push_back(Says("the server says that it takes UDP, and why", *lab.server, ""));
  findings.back().held = lab.server->Output().find("UDP (no RouDi listens") != std::string::npos;
  findings.back().found = findings.back().held ? "it does" : lab.server->Output();
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

Findings SharedMemoryFills(int domain) {
  Lab lab(domain, "auto");
  OwnMemory memory(lab, "160m");
  if (!memory.is_there()) return {memory.Skipped()};
  test::Program roudi = memory.RouDi();
  Findings findings{Says("RouDi is ready", roudi, "ready for clients")};
  lab.StartServer();
  lab.StartStation();
  const bool shared = lab.server->Output().find("shared memory (RouDi") != std::string::npos;
  findings.push_back(
      {"the loop goes over shared memory", shared ? "it does" : lab.server->Output(), shared});
  Wait(1.0);
  const std::string before = lab.station->Output();
  const std::size_t filled = memory.Fill();
  Wait(2.0);
  findings.push_back(Undisturbed(lab, before));
  findings.back().found += fmt::format(", {:.0f} MB taken", 1e-6 * static_cast<double>(filled));
  findings.push_back(Lives("the server", *lab.server));
  findings.push_back(Lives("RouDi", roudi));
  findings.push_back(lab.JudgeTheHand());
  // Restarts everything in what is left.
  lab.station.reset();
  lab.server->Signal(SIGTERM);
  lab.server->Exit(30.0);
  AllServe(lab, findings);
  findings.push_back(lab.JudgeTheHand());
  return findings;
}

}  // namespace palpate::faults
