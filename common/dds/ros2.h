#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <dds/dds.h>

#include "common/dds/endpoint.h"
#include "common/dds/network.h"
#include "idl/ros2.h"

/// DDS with the names, quality of service and ports of ROS 2, for a bridge (client/crtk).
namespace palpate::ros2 {

using Header = std_msgs_msg_dds__Header_;

// The message types, each with its package and its type hash, which ROS 2 (Iron and later)
// publishes in the USER_DATA of each endpoint as "typehash=RIHS01_...;": SHA-256 of the type's
// description as JSON (REP-2016).  A test computes them from the definitions and compares them with
// published ones.
#define PALPATE_ROS_TYPES(X)                                                   \
  X(geometry_msgs_msg, PoseStamped,                                            \
    "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8") \
  X(geometry_msgs_msg, TwistStamped,                                           \
    "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64") \
  X(geometry_msgs_msg, WrenchStamped,                                          \
    "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77") \
  X(crtk_msgs_msg, OperatingState,                                             \
    "RIHS01_5cc57eea589b217fe5194bf2735b91d4a7f2dd5ac1245ae657f7ea7590c2c80e") \
  X(crtk_msgs_msg, StringStamped,                                              \
    "RIHS01_83efb802e6596e03f69ac322e3231037329946f2bd13ed48874d97f5b8f5db1d")

template <class T>
constexpr const char* kTypeHash = nullptr;
#define PALPATE_ROS_TYPE(package, T, hash) \
  using T = package##_dds__##T##_;         \
  template <>                              \
  inline constexpr const char* kTypeHash<T> = hash;
PALPATE_ROS_TYPES(PALPATE_ROS_TYPE)
#undef PALPATE_ROS_TYPE

/// Returns the DDS topic of a ROS topic: "rt" before its full name, which begins with '/'.
std::string DdsTopic(const std::string& ros_name);

/// The greatest ROS_DOMAIN_ID: the ports of a higher one would be beyond 65535.
inline constexpr int kMaxDomain = 232;

/// A participant in a ROS 2 domain.  It uses the standard's ports (7400 + 250 N), which are not
/// those of Palpate's own domains, and never shared memory.
class Participant {
 public:
  /// @param domain   ROS_DOMAIN_ID.
  /// @param network  its interface and peers; the identity is not used on the ROS side.
  /// Throws Error.
  Participant(int domain, const dds::Network& network);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  dds_entity_t handle() const { return participant_; }

 private:
  dds_entity_t domain_ = 0, participant_ = 0;
};

/// Writer with the defaults of a ROS 2 publisher (reliable, volatile), except that it keeps the
/// last 1000 samples.  Never blocks: a reader that falls behind by a second loses the oldest.
template <class T>
class Writer : public dds::Endpoint {
 public:
  /// Throws Error.
  Writer(const Participant& participant, const std::string& ros_name);
  /// Writes a message; false if DDS refuses it.  Thread contract: any thread.
  bool Write(const T& message) noexcept;
  int matched_readers() const noexcept;
};

enum class Wants {
  kAll,     ///< reliable, keep last 10
  kNewest,  ///< best effort, keep last 1: also matches reliable writers
};

/// Reader of messages that any participant in the domain may send.
template <class T>
class Reader : public dds::Endpoint {
 public:
  /// Throws Error.
  Reader(const Participant& participant, const std::string& ros_name, Wants wants);
  /// Calls take(message) for each message that has arrived.  Its strings are valid during the call.
  template <class Take>
  void Poll(Take take) {
    for (;;) {
      void* loan[1] = {nullptr};
      dds_sample_info_t info;
      if (dds_take(handle(), loan, &info, 1, 1) != 1) return;
      if (info.valid_data) take(*static_cast<const T*>(loan[0]));
      dds_return_loan(handle(), loan, 1);
    }
  }
};

}  // namespace palpate::ros2
