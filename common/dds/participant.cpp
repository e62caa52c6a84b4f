#include "common/dds/participant.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <utility>

#include <fcntl.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "common/dds/open_domain.h"
#include "common/dds/ports.h"
#include "common/dds/security.h"
#include "common/dds/shared_memory_watch.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/project_files.h"

namespace palpate::dds {
namespace {

constexpr const char* kRouDiSocket = "/tmp/roudi";  // iceoryx 2.0: IPC channel "roudi"
constexpr const char* kRouDiLock = "/tmp/iox-unique-roudi.lock";
std::string StartRouDi() {
  return "start 'iox-roudi -c " + ShownPlaceOf(ProjectFile::kSharedMemory) + "'";
}

/// Identifies a RouDi: each one creates a new socket.
struct SocketIdentity {
  ino_t inode = 0;
  std::int64_t made_ns = 0;
  bool operator==(const SocketIdentity&) const = default;
};

SocketIdentity RouDiIdentity() {
  struct stat status {};
  if (stat(kRouDiSocket, &status) != 0) return {};
  return {status.st_ino,
          status.st_ctim.tv_sec * std::int64_t{1'000'000'000} + status.st_ctim.tv_nsec};
}

/// Returns true if the socket belongs to this user or root, or only a group of this process may use
/// it: the members of that group could do as much harm in the shared memory.
bool IsTrusted(const struct stat& socket) {
  if (socket.st_uid == geteuid() || socket.st_uid == 0) return true;
  if ((socket.st_mode & S_IWOTH) != 0 || (socket.st_mode & S_IWGRP) == 0) return false;
  if (socket.st_gid == getegid()) return true;
  std::array<gid_t, 256> groups;
  const int count = getgroups(static_cast<int>(groups.size()), groups.data());
  return std::find(groups.begin(), groups.begin() + std::max(count, 0), socket.st_gid) !=
         groups.begin() + std::max(count, 0);
}

/// Returns true if a process of that user holds the lock file.
bool IsHeld(const char* lock_file, uid_t user) {
  struct stat status {};
  if (lstat(lock_file, &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != user) {
    return false;
  }
  const int fd = open(lock_file, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return errno == EACCES;  // another user's, and exists, though we may not read it
  const bool held = flock(fd, LOCK_SH | LOCK_NB) != 0;
  close(fd);  // unlocks
  return held;
}

/// Returns an attribute's value for XML.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '&' || c == '<') {
      quoted += "&#" + std::to_string(c) + ";";
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

/// Returns true if the interface exists on this host and has an IPv4 address.
bool HasAddress(const std::string& interface) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return false;
  bool found = false;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    found |= each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
             interface == each->ifa_name;
  }
  freeifaddrs(all);
  return found;
}

std::string WhyNoDomain(int domain_id, const Network& network) {
  if (!HasAddress(network.interface)) {
    return "there is no interface '" + network.interface +
           "' with an address (give another --network)";
  }
  if (network.secured()) {
    return "this --identity or its network is not valid; see the messages of Cyclone DDS above "
           "('palpate-identities list' shows when identities expire)";
  }
  const std::string why = WhyPortsFail(domain_id, PortsInUse(), PortsOfAnyone());
  return why.empty() ? "Cyclone DDS says above why" : why;
}

std::string DiscoveryConfig(int domain_id, const Network& network) {
  std::string peers;
  for (const std::string& peer : network.peers) peers += "<Peer Address=" + Quoted(peer) + "/>";
  return "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>" +
         std::to_string(kMaxParticipantIndex) + "</MaxAutoParticipantIndex><Ports><Base>" +
         std::to_string(kFirstPort) + "</Base><DomainGain>" + std::to_string(kPortsPerDomain) +
         "</DomainGain></Ports><LeaseDuration>" + (IsServiceDomain(domain_id) ? "3s" : "10s") +
         "</LeaseDuration>" + (network.this_host() ? "" : "<SPDPInterval>1s</SPDPInterval>") +
         "<Peers>" + peers + "</Peers></Discovery>";
}

/// Why each line is there:
/// - `lo` has no MULTICAST flag, so multicast must be allowed explicitly for discovery; only
/// discovery uses
///   multicast (`spdp`), data goes to each reader by itself.
/// - A network loses announcements, and the next is due after 30 s by default.
/// - A killed process counts as present until its lease ends, and a gateway waits that long before
/// it receives from a server's successor.  The loop's lease is longer, because a peer that was
/// frozen meanwhile would come back as an unknown writer, whose samples leak chunks; there the
/// stations detect silence themselves.
///   - Peers are contacted in addition to multicast.
/// - A participant index gives fixed ports, those of common/dds/ports.h, so that a crowded domain
///   is an error at start.
/// - Shared memory does not know domains: without a prefix per domain, another domain's writer on
///   the same topic fills our reader until it dies.
/// - The locator identifies the machine.  By default it is made from a network interface's address,
/// and two containers that share memory would then get every sample twice.
std::string DomainConfig(int domain_id, bool shared_memory, const Network& network) {
  std::string xml =
      "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=" +
      Quoted(network.interface) +
      " multicast=\"true\"/></Interfaces><AllowMulticast>spdp</AllowMulticast></General>" +
      DiscoveryConfig(domain_id, network) +
      // Refusals in a secured domain are warnings.
      "<Tracing><Verbosity>" + (network.secured() ? "warning" : "severe") +
      "</Verbosity><OutputFile>stderr</OutputFile></Tracing>";
  if (network.secured()) xml += SecurityConfig(network.identity);
  if (network.receive_buffer > 0) {  // no minimum: with one, a host that allows less is an error
    xml += "<Internal><SocketReceiveBufferSize max=\"" + std::to_string(network.receive_buffer) +
           " B\"/></Internal>";
  }
  xml += shared_memory
             ? "<SharedMemory><Enable>true</Enable><LogLevel>warn</LogLevel><Prefix>palpate_" +
                   std::to_string(domain_id) +
                   "</Prefix><Locator>70:61:6c:70:61:74:65:00:00:00:00:00:00:00:00:01</Locator></"
                   "SharedMemory>"
             : "<SharedMemory><Enable>false</Enable></SharedMemory>";
  return xml + "</Domain></CycloneDDS>";
}

void WatchTheEnd() {
  // Never destroyed, because that would happen before iceoryx disconnects.
  alignas(SharedMemoryWatch) static std::byte place[sizeof(SharedMemoryWatch)];
  new (place) SharedMemoryWatch("taking leave of RouDi");
}

}  // namespace

Transport ParseTransport(const std::string& text) {
  if (text == "auto") return Transport::kAuto;
  if (text == "shm") return Transport::kSharedMemory;
  if (text == "udp") return Transport::kUdp;
  throw UsageError("--transport: '" + text + "' is not known; give auto, shm or udp");
}

const char* ToString(Transport transport) {
  switch (transport) {
    case Transport::kSharedMemory:
      return "shared memory";
    case Transport::kUdp:
      return "UDP";
    default:
      return "auto";
  }
}

std::optional<std::string> WhyNoRouDi() {
  const std::string none = std::string("no RouDi listens at ") + kRouDiSocket;
  struct stat status {};
  if (lstat(kRouDiSocket, &status) != 0 || !S_ISSOCK(status.st_mode)) return none;
  if (!IsTrusted(status)) {
    return std::string(kRouDiSocket) + " is another user's (uid " + std::to_string(status.st_uid) +
           ") and of no group of this one; shared memory joins programs of one user or group";
  }
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return std::string("no socket can be made: ") + std::strerror(errno);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, kRouDiSocket);
  // A datagram socket that no process has open refuses the connection.
  const bool answers = connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  if (!answers) return none;
  if (!IsHeld(kRouDiLock, status.st_uid)) {
    return std::string("what listens at ") + kRouDiSocket + " is no RouDi: it does not hold " +
           kRouDiLock;
  }
  return std::nullopt;
}

TransportChoice ChooseTransport(Transport wanted, const Network& network) {
  if (network.secured()) {
    if (wanted == Transport::kSharedMemory) {
      throw Error(
          "--transport shm and --identity exclude each other, because shared memory bypasses DDS "
          "Security; omit one of them");
    }
    return {Transport::kUdp, "UDP (secured, over " + network.interface + ")"};
  }
  if (!network.this_host()) {
    if (wanted == Transport::kSharedMemory) {
      throw Error("--transport shm works within one host only; omit --network '" +
                  network.interface + "', or give --transport auto or udp");
    }
    return {Transport::kUdp, "UDP (over " + network.interface + ")"};
  }
  if (wanted == Transport::kUdp) return {Transport::kUdp, "UDP (as asked)"};
  const std::optional<std::string> why_not = WhyNoRouDi();
  if (!why_not) return {Transport::kSharedMemory, "shared memory (RouDi answers)"};
  if (wanted == Transport::kSharedMemory) {
    throw Error("--transport shm: " + *why_not + "; " + StartRouDi() +
                " (same user and same /tmp), or give --transport auto or udp");
  }
  return {Transport::kUdp, "UDP (" + *why_not + "; " + StartRouDi() + " first for shared memory)"};
}

/// Returns a domain as the user has named it, beside the number that other DDS programs use.
std::string InWords(int id) {
  return "--domain " + std::to_string(id / 2) + " (DDS domain " + std::to_string(id) + ")";
}

/// A domain entity; one per process and id, since DDS allows no second one.
class Participant::Domain {
 public:
  Domain(int id, bool shared_memory, const Network& network)
      : shared_memory_(shared_memory), roudi_(RouDiIdentity()) {
    if (network.secured()) LogWhatDdsSays();
    entity_ = OpenDomain(static_cast<dds_domainid_t>(id), DomainConfig(id, shared_memory, network),
                         network, PortsOf(id));
    if (entity_ < 0) {
      throw Error(InWords(id) + " cannot be made (" + dds_strretcode(entity_) +
                  "): " + WhyNoDomain(id, network));
    }
    // Runs before the exit handler that iceoryx has registered: its disconnection from RouDi may
    // hang, too.
    if (shared_memory) [[maybe_unused]]
      static const int registered = std::atexit(WatchTheEnd);
  }
  ~Domain() { dds_delete(entity_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  bool shared_memory() const { return shared_memory_; }
  bool shared_memory_lost() const {
    return shared_memory_ && (WhyNoRouDi() || RouDiIdentity() != roudi_);
  }

 private:
  bool shared_memory_;
  SocketIdentity roudi_;
  dds_entity_t entity_ = 0;
};

Participant Participant::Make(int domain_id, bool shared_memory, const Network& network) {
  static std::map<int, std::weak_ptr<const Domain>> open;
  std::optional<SharedMemoryWatch> watch;
  if (shared_memory) watch.emplace("making a participant");
  std::shared_ptr<const Domain> domain = open[domain_id].lock();
  if (!domain) {
    domain = std::make_shared<const Domain>(domain_id, shared_memory, network);
    open[domain_id] = domain;
  } else if (domain->shared_memory() != shared_memory) {
    throw Error(InWords(domain_id) + " is already open in this process with another transport");
  }
  const dds_entity_t participant =
      dds_create_participant(static_cast<dds_domainid_t>(domain_id), nullptr, nullptr);
  if (participant < 0) {
    throw Error(InWords(domain_id) + ": no participant (" + dds_strretcode(participant) +
                "): " + WhyNoDomain(domain_id, network));
  }
  return {std::move(domain), participant};
}

Participant Participant::Loop(int domain, const TransportChoice& choice, const Network& network) {
  return Make(LoopDomainId(domain), choice.transport == Transport::kSharedMemory, network);
}

Participant Participant::Service(int domain, const Network& network) {
  return Make(ServiceDomainId(domain), false, network);
}

Participant::Participant(std::shared_ptr<const Domain> domain, dds_entity_t participant)
    : domain_(std::move(domain)), participant_(participant) {}

Participant::~Participant() {
  if (participant_ > 0) dds_delete(participant_);
}

Participant::Participant(Participant&& other) noexcept
    : domain_(std::move(other.domain_)), participant_(std::exchange(other.participant_, 0)) {}

Participant& Participant::operator=(Participant&& other) noexcept {
  std::swap(domain_, other.domain_);
  std::swap(participant_, other.participant_);
  return *this;
}

bool Participant::shared_memory() const {
  return domain_ && domain_->shared_memory();
}

bool Participant::shared_memory_lost() const {
  return domain_ && domain_->shared_memory_lost();
}

}  // namespace palpate::dds
