#pragma once

#include <memory>
#include <optional>
#include <string>

#include <dds/dds.h>

#include "common/dds/network.h"

namespace palpate::dds {

enum class Transport {
  kAuto,  ///< shared memory if RouDi answers, else UDP
  kSharedMemory,
  kUdp,
};

/// Parses "auto", "shm", "udp"; throws UsageError.
Transport ParseTransport(const std::string& text);
const char* ToString(Transport transport);

/// The chosen transport and the reason, for the log: "shared memory (RouDi answers)" or
/// "UDP (no RouDi: start it with ... for shared memory)".
struct TransportChoice {
  Transport transport;  ///< kSharedMemory or kUdp
  std::string reason;
};

/// Returns nothing if a live RouDi of this user listens at its socket; else the reason why there is
/// none, for people.  A socket without a live RouDi behind it (left by one that was killed, say)
/// does not count: iceoryx would wait for it and then end this process.
std::optional<std::string> WhyNoRouDi();

/// Chooses the transport.  Checks for RouDi first: without it dds_create_participant would block
/// for 60 s and then abort.
/// Throws Error, with the remedy, if shared memory is requested but RouDi does not answer or the
/// network is not this host.
TransportChoice ChooseTransport(Transport wanted, const Network& network = {});

/// A participant in one DDS domain, which is configured by code (never by CYCLONEDDS_URI).  A
/// program makes two: one in the loop domain (HapticPose and Wrench alone; shared memory if chosen)
/// and one in the service domain (UDP; everything else).  Participants of one process share a
/// domain, which ends with the last of them.  Both domains use one interface alone, that of the
/// network; if that is this host's own, they receive from nowhere else (common/dds/open_domain.h).
/// Thread contract: several threads must not make participants at the same time.
class Participant {
 public:
  /// Makes a participant in the loop domain.  This creates the threads that receive samples, which
  /// are the servo loops: they inherit the caller's scheduling class, priority and CPU affinity
  /// (common/program/realtime.h).
  /// Throws Error if the domain cannot be made, or is open in this process with another transport.
  static Participant Loop(int domain, const TransportChoice& choice, const Network& network = {});
  static Participant Service(int domain, const Network& network = {});
  ~Participant();
  Participant(Participant&& other) noexcept;
  Participant& operator=(Participant&& other) noexcept;

  dds_entity_t handle() const { return participant_; }
  /// Returns true if the domain was made with shared memory.
  bool shared_memory() const;
  /// Returns true if the domain uses shared memory and its RouDi has ended or been replaced by
  /// another. Existing endpoints go on, but a new endpoint over shared memory would abort the
  /// process; writers and readers made from then on use UDP.
  bool shared_memory_lost() const;

 private:
  class Domain;
  static Participant Make(int domain_id, bool shared_memory, const Network& network);
  Participant(std::shared_ptr<const Domain> domain, dds_entity_t participant);
  std::shared_ptr<const Domain> domain_;
  dds_entity_t participant_ = 0;
};

}  // namespace palpate::dds
