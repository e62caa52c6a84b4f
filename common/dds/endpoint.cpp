#include "common/dds/endpoint.h"

#include <optional>

#include <dds/ddsc/dds_loan_api.h>

#include "common/dds/shared_memory_watch.h"
#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate::dds {
namespace {

struct QosDelete {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, QosDelete>;

int DepthOf(Qos role) {
  if (role == Qos::kRecord || role == Qos::kRecordSession) return 256;
  return role == Qos::kLoop ? 8 : 1;
}

// clang-format off
/// role      reliability  durability       history      why
/// kLoop     best effort  volatile         keep last 8  late is as bad as lost; eight, because a
///                                                      burst must fit shared memory's queue
/// kSession  reliable     transient-local  keep last 1  who comes later learns what holds now
/// kStream   best effort  volatile         keep last 1  a viewer wants the newest, and must never
///                                                      be able to slow the writer
// clang-format on
/// kRecord, kRecordSession: as those that they read, keep last 256
/// Nothing is keep-all (a writer would block, and it disables shared memory), and no deadline is
/// finite (which also disables shared memory).  A writer's end does not dispose its instances,
/// so the last state of a server remains known while there is none; servers dispose ended
/// instances explicitly.
QosPtr MakeQos(const Participant& participant, Qos role) {
  QosPtr qos(dds_create_qos());
  if (role == Qos::kSession || role == Qos::kRecordSession) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    dds_qset_writer_data_lifecycle(qos.get(), false);
  } else {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  }
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, DepthOf(role));
  // iceoryx cannot ignore endpoints of its own process, so with this setting Cyclone DDS does not
  // use shared memory for the endpoint.
  if (participant.shared_memory_lost()) dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PROCESS);
  return qos;
}

/// Returns the error that DDS cannot make a `what` of that name, in a secured domain with
/// the remedy.
Error CannotMake(const std::string& what, const std::string& name, dds_return_t why) {
  std::string remedy;
  if (why == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    remedy = "; the role of this --identity may not: 'palpate-identities --help' says which may";
    if (const auto session = SessionOfTopic(name)) {
      remedy += "; or it was made for another station than '" + session->first +
                "': give the --id (of palpate-load the --name) that it was made for";
    }
  }
  return Error("DDS " + what + " '" + name + "': " + dds_strretcode(why) + remedy);
}

template <class T>
dds_entity_t MakeTopic(const Participant& participant, const std::string& name) {
  const dds_entity_t topic = dds_create_topic(participant.handle(), &wire::Descriptor<T>(),
                                              name.c_str(), nullptr, nullptr);
  if (topic < 0) throw CannotMake("topic", name, topic);
  return topic;
}

/// Before the reader is made: each of ours has a topic of its own, and with it a filter.
void SetAdmission(dds_entity_t topic, Admission& admission) {
  dds_topic_filter filter{};
  filter.mode = DDS_TOPIC_FILTER_SAMPLEINFO_ARG;
  filter.arg = &admission;
  filter.f.sampleinfo_arg = [](const dds_sample_info_t* info, void* arg) {
    return static_cast<Admission*>(arg)->Admits(info->publication_handle, info->instance_handle);
  };
  dds_set_topic_filter_extended(topic, &filter);
}

dds_entity_t Made(dds_entity_t endpoint, const char* what, const std::string& name) {
  if (endpoint > 0) return endpoint;
  throw CannotMake(std::string(what) + " of topic", name, endpoint);
}

/// Returns a watchdog for making or deleting an endpoint, if shared memory is involved.
std::optional<SharedMemoryWatch> Watch(bool shared_memory, const std::string& doing) {
  if (!shared_memory) return std::nullopt;
  return std::optional<SharedMemoryWatch>(std::in_place, doing);
}

template <class T>
bool TakeValid(dds_entity_t reader, T& sample) noexcept {
  void* samples[1] = {&sample};
  dds_sample_info_t info;
  while (dds_take(reader, samples, &info, 1, 1) == 1) {
    if (info.valid_data) return true;
  }
  return false;
}

}  // namespace

Endpoint::~Endpoint() {
  const auto watch =
      Watch(endpoint_ > 0 && dds_is_shared_memory_available(endpoint_), "deleting an endpoint");
  if (endpoint_ > 0) dds_delete(endpoint_);
  if (topic_ > 0) dds_delete(topic_);
}

Endpoint& Endpoint::operator=(Endpoint&& other) noexcept {
  std::swap(topic_, other.topic_);
  std::swap(endpoint_, other.endpoint_);
  std::swap(listens_, other.listens_);
  return *this;
}

bool Endpoint::uses_shared_memory() const noexcept {
  return dds_is_shared_memory_available(endpoint_);
}

template <class T>
Writer<T>::Writer(const Participant& participant, const std::string& topic, Qos qos) {
  topic_ = MakeTopic<T>(participant, topic);
  const auto watch = Watch(participant.shared_memory(), "making a writer of " + topic);
  endpoint_ = Made(
      dds_create_writer(participant.handle(), topic_, MakeQos(participant, qos).get(), nullptr),
      "writer", topic);
}

template <class T>
bool Writer<T>::Write(const T& sample) noexcept {
  return dds_write(endpoint_, &sample) == DDS_RETCODE_OK;
}

template <class T>
void Writer<T>::Dispose(const T& sample) noexcept {
  dds_dispose(endpoint_, &sample);
  dds_unregister_instance(endpoint_, &sample);
}

template <class T>
int Writer<T>::matched_readers() const noexcept {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(endpoint_, &status) == DDS_RETCODE_OK
             ? static_cast<int>(status.current_count)
             : 0;
}

template <class T>
struct Reader<T>::State {
  Callback on_sample;
  T sample;

  static void OnDataAvailable(dds_entity_t reader, void* arg) {
    auto* state = static_cast<State*>(arg);
    while (TakeValid(reader, state->sample)) state->on_sample(state->sample);
  }
};

template <class T>
Reader<T>::Reader(const Participant& participant, const std::string& topic, Qos qos,
                  Callback on_sample, Admission* admission) {
  topic_ = MakeTopic<T>(participant, topic);
  if (admission != nullptr) SetAdmission(topic_, *admission);
  std::unique_ptr<dds_listener_t, decltype(&dds_delete_listener)> listener(nullptr,
                                                                           dds_delete_listener);
  if (on_sample) {
    listens_.reset(new State{std::move(on_sample), T{}});
    listener.reset(dds_create_listener(listens_.get()));
    dds_lset_data_available(listener.get(), &State::OnDataAvailable);
  }
  const auto watch = Watch(participant.shared_memory(), "making a reader of " + topic);
  endpoint_ = Made(dds_create_reader(participant.handle(), topic_, MakeQos(participant, qos).get(),
                                     listener.get()),
                   "reader", topic);
}

template <class T>
bool Reader<T>::Take(T& sample) noexcept {
  return TakeValid(endpoint_, sample);
}

template <class T>
int Reader<T>::matched_writers() const noexcept {
  dds_subscription_matched_status_t status{};
  return dds_get_subscription_matched_status(endpoint_, &status) == DDS_RETCODE_OK
             ? static_cast<int>(status.current_count)
             : 0;
}

bool WriterDiscovered(const Participant& participant, const std::string& topic) {
  const dds_entity_t reader =
      dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  if (reader < 0) return false;
  bool found = false;
  void* samples[1] = {nullptr};
  dds_sample_info_t info;
  while (!found && dds_take(reader, samples, &info, 1, 1) == 1) {
    const auto* endpoint = static_cast<const dds_builtintopic_endpoint_t*>(samples[0]);
    found = info.valid_data && info.instance_state == DDS_ALIVE_INSTANCE_STATE &&
            topic == endpoint->topic_name;
    dds_return_loan(reader, samples, 1);
    samples[0] = nullptr;
  }
  dds_delete(reader);
  return found;
}

#define PALPATE_ENDPOINTS(T)      \
  template class Writer<wire::T>; \
  template class Reader<wire::T>;
PALPATE_LOOP_TYPES(PALPATE_ENDPOINTS)
PALPATE_SERVICE_TYPES(PALPATE_ENDPOINTS)
#undef PALPATE_ENDPOINTS

}  // namespace palpate::dds
