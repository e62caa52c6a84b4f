#include "common/dds/ros2.h"

#include "common/dds/open_domain.h"
#include "common/error.h"

namespace palpate::ros2 {
namespace {

/// A reader's history depth, ROS 2's default.
constexpr int kDepth = 10;
/// A writer's history depth, one second at 1 kHz, so that a reader that is delayed or loses
/// datagrams gets them again.  Acknowledged samples are not kept, and the depths of writer and
/// reader may differ.
constexpr int kWriterDepth = 1000;
/// First number of ROS domains within this process, distinct from those of Palpate's own; on the
/// wire a domain has ROS's number.
constexpr int kFirstLocal = 1000;

template <class T>
const dds_topic_descriptor_t& Descriptor();
#define PALPATE_ROS_DESCRIPTOR(package, T, hash)  \
  template <>                                     \
  const dds_topic_descriptor_t& Descriptor<T>() { \
    return package##_dds__##T##__desc;            \
  }
PALPATE_ROS_TYPES(PALPATE_ROS_DESCRIPTOR)
#undef PALPATE_ROS_DESCRIPTOR

struct QosDelete {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, QosDelete>;

QosPtr MakeQos(Wants wants, int depth, const std::string& user_data) {
  QosPtr qos(dds_create_qos());
  const bool all = wants == Wants::kAll;
  dds_qset_reliability(qos.get(), all ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  return qos;
}

template <class T>
std::string UserData() {
  return std::string("typehash=") + kTypeHash<T> + ";";
}

dds_entity_t Checked(dds_entity_t entity, const std::string& what) {
  if (entity > 0) return entity;
  throw Error(what + ": " + dds_strretcode(entity));
}

template <class T>
dds_entity_t MakeTopic(const Participant& participant, const std::string& ros_name) {
  return Checked(dds_create_topic(participant.handle(), &Descriptor<T>(),
                                  DdsTopic(ros_name).c_str(), nullptr, nullptr),
                 "topic " + ros_name);
}

std::string Config(int domain, const dds::Network& network) {
  std::string peers;
  for (const std::string& peer : network.peers) peers += "<Peer Address=\"" + peer + "\"/>";
  // `lo` has no MULTICAST flag, so multicast must be allowed explicitly for discovery; data is sent
  // by unicast.
  return "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"" +
         network.interface +
         "\" multicast=\"true\"/></Interfaces><AllowMulticast>spdp</AllowMulticast></General>"
         "<Discovery><ExternalDomainId>" +
         std::to_string(domain) +
         "</ExternalDomainId><ParticipantIndex>auto</ParticipantIndex>"
         "<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers>" +
         peers +
         "</Peers></Discovery>"
         "<Tracing><Verbosity>severe</Verbosity><OutputFile>stderr</OutputFile></Tracing>"
         "<SharedMemory><Enable>false</Enable></SharedMemory></Domain></CycloneDDS>";
}

}  // namespace

std::string DdsTopic(const std::string& ros_name) {
  return "rt" + ros_name;
}

Participant::Participant(int domain, const dds::Network& network) {
  const std::string what =
      "ROS domain " + std::to_string(domain) + " on '" + network.interface + "'";
  const auto local = static_cast<dds_domainid_t>(kFirstLocal + domain);
  const std::string remedy = " (give an interface that exists and has an address)";
  const int first_port = 7400 + 250 * domain;  // RTPS 2.3, 9.6.1.1
  domain_ =
      dds::OpenDomain(local, Config(domain, network), network, {first_port, first_port + 249});
  if (domain_ < 0) throw Error(what + " cannot be joined: " + dds_strretcode(domain_) + remedy);
  // ROS 2 recognises its own participants by this.
  const QosPtr qos = MakeQos(Wants::kAll, kDepth, "enclave=/;");
  participant_ = dds_create_participant(local, qos.get(), nullptr);
  if (participant_ < 0) {
    const dds_entity_t why = participant_;
    dds_delete(domain_);
    throw Error(what + " cannot be joined: " + dds_strretcode(why) + remedy);
  }
}

Participant::~Participant() {
  dds_delete(domain_);  // deletes everything in it, too
}

template <class T>
Writer<T>::Writer(const Participant& participant, const std::string& ros_name) {
  topic_ = MakeTopic<T>(participant, ros_name);
  const QosPtr qos = MakeQos(Wants::kAll, kWriterDepth, UserData<T>());
  endpoint_ = Checked(dds_create_writer(participant.handle(), topic_, qos.get(), nullptr),
                      "writer of " + ros_name);
}

template <class T>
bool Writer<T>::Write(const T& message) noexcept {
  return dds_write(endpoint_, &message) == DDS_RETCODE_OK;
}

template <class T>
int Writer<T>::matched_readers() const noexcept {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(endpoint_, &status) == DDS_RETCODE_OK
             ? static_cast<int>(status.current_count)
             : 0;
}

template <class T>
Reader<T>::Reader(const Participant& participant, const std::string& ros_name, Wants wants) {
  topic_ = MakeTopic<T>(participant, ros_name);
  const QosPtr qos = MakeQos(wants, wants == Wants::kAll ? kDepth : 1, UserData<T>());
  endpoint_ = Checked(dds_create_reader(participant.handle(), topic_, qos.get(), nullptr),
                      "reader of " + ros_name);
}

#define PALPATE_ROS_ENDPOINTS(package, T, hash) \
  template class Writer<T>;                     \
  template class Reader<T>;
PALPATE_ROS_TYPES(PALPATE_ROS_ENDPOINTS)
#undef PALPATE_ROS_ENDPOINTS

}  // namespace palpate::ros2
