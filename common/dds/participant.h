#pragma once

#include <dds/dds.h>

#include <string>

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

/// Looks for RouDi first: without it dds_create_participant would block for 60 s and abort.
/// Throws Error where shared memory is asked for and RouDi does not answer, with the remedy.
TransportChoice ChooseTransport(Transport wanted);

/// One DDS domain of this process, configured from code (never by CYCLONEDDS_URI), and a participant
/// in it.  Two are made: the loop domain (shared memory where chosen; HapticPose and Wrench alone)
/// and the service domain (UDP; everything else).
class Participant {
 public:
  static Participant Loop(int domain, const TransportChoice& choice);
  static Participant Service(int domain);
  ~Participant();
  Participant(Participant&& other) noexcept;
  Participant& operator=(Participant&& other) noexcept;

  dds_entity_t handle() const { return participant_; }
  bool shared_memory() const { return shared_memory_; }

 private:
  Participant(dds_entity_t domain, dds_entity_t participant, bool shared_memory)
      : domain_(domain), participant_(participant), shared_memory_(shared_memory) {}
  dds_entity_t domain_ = 0;
  dds_entity_t participant_ = 0;
  bool shared_memory_ = false;
};

}  // namespace palpate::dds
