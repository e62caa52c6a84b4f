#pragma once

#include <memory>
#include <optional>
#include <string>

#include <dds/dds.h>

#include "common/dds/network.h"

namespace palpate::dds {

enum class Transport {
  kAuto,  ///< shared memory where RouDi answers, else UDP
  kSharedMemory,
  kUdp,
};

/// Parses "auto", "shm", "udp"; throws UsageError.
Transport ParseTransport(const std::string& text);
const char* ToString(Transport transport);

/// What was chosen and why, for the log: "shared memory (RouDi answers)" or
/// "UDP (no RouDi: start it with ... for shared memory)".
struct TransportChoice {
  Transport transport;  ///< kSharedMemory or kUdp
  std::string reason;
};

/// Nothing where a live RouDi of this user listens at its socket; else why not, for a person.  A
/// socket left by a killed one does not count, nor one behind which there is no RouDi: iceoryx
/// would wait for it and then end this process.
std::optional<std::string> WhyNoRouDi();

/// Looks for RouDi first: without it dds_create_participant would block for 60 s and abort.
/// Throws Error where shared memory is asked for and RouDi does not answer or the network is not
/// this host, with the remedy.
TransportChoice ChooseTransport(Transport wanted, const Network& network = {});

/// A participant in one DDS domain, which is configured from code (never by CYCLONEDDS_URI).  Two
/// are made: the loop domain (shared memory where chosen; HapticPose and Wrench alone) and the
/// service domain (UDP; everything else).  Participants of one process share a domain; it ends with
/// the last of them.  Both domains know one interface alone, that of the network,
/// and where that is this host's own nothing else is heard (common/dds/open_domain.h).
/// Not to be made by several threads at once.
class Participant {
 public:
  /// The threads that receive samples are made here and inherit the caller's scheduling class,
  /// priority and CPU affinity (common/program/realtime.h): they are the servo loop.
  /// Throws Error where the domain cannot be made, or is open in this process with another
  /// transport.
  static Participant Loop(int domain, const TransportChoice& choice, const Network& network = {});
  static Participant Service(int domain, const Network& network = {});
  ~Participant();
  Participant(Participant&& other) noexcept;
  Participant& operator=(Participant&& other) noexcept;

  dds_entity_t handle() const { return participant_; }
  /// What the domain was made with.
  bool shared_memory() const;
  /// True where that was shared memory and its RouDi has gone, or another has taken its place: what
  /// is open goes on, but a new endpoint over shared memory would abort the process.  Writers and
  /// readers made from then on use UDP.
  bool shared_memory_lost() const;

 private:
  class Domain;
  static Participant Make(int domain_id, bool shared_memory, const Network& network);
  Participant(std::shared_ptr<const Domain> domain, dds_entity_t participant);
  std::shared_ptr<const Domain> domain_;
  dds_entity_t participant_ = 0;
};

}  // namespace palpate::dds
