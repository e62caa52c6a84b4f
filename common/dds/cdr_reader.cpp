#include "common/dds/cdr_reader.h"

#include <algorithm>
#include <memory>

#include <dds/ddsi/ddsi_serdata.h>

namespace palpate::dds {
namespace {

constexpr std::size_t kMostWriters = 256;  // greatest number remembered per topic

/// Returns the participant of a writer; 0 if the writer has left.
std::uint64_t ParticipantOf(dds_entity_t reader, dds_instance_handle_t writer) {
  const std::unique_ptr<dds_builtintopic_endpoint_t, decltype(&dds_builtintopic_free_endpoint)>
      endpoint(dds_get_matched_publication_data(reader, writer), dds_builtintopic_free_endpoint);
  return endpoint ? endpoint->participant_instance_handle : 0;
}

}  // namespace

KnownWriters::Writer& KnownWriters::Of(std::uint64_t writer) {
  if (writers_.size() >= kMostWriters && !writers_.contains(writer)) {
    writers_.clear();  // drops entries of writers that have left
  }
  return writers_[writer];
}

bool KnownWriters::Admits(std::uint64_t writer, std::uint64_t instance) {
  if (!source_) return true;
  const std::lock_guard lock(mutex_);
  Writer& of = Of(writer);
  if (of.participant != 0 && !source_->Allows(of.participant)) return false;
  if (source_->most_instances == Source::kAll) return true;
  if (of.instances.size() < source_->most_instances) of.instances.insert(instance);
  return of.instances.contains(instance);
}

template <class Find>
std::uint64_t KnownWriters::OriginOf(std::uint64_t writer, Find find) {
  {
    const std::lock_guard lock(mutex_);
    if (const std::uint64_t known = Of(writer).participant; known != 0) return known;
  }
  const std::uint64_t participant = find();  // without the lock: it calls DDS
  const std::lock_guard lock(mutex_);
  return Of(writer).participant = participant;
}

template <class T>
bool CdrReader<T>::Take(CdrSample& raw, T& sample, bool overs) {
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  while (dds_takecdr(reader_.handle(), &data, 1, &info, DDS_ANY_STATE) == 1) {
    FreeContents(sample);
    raw.over =
        overs && !info.valid_data && info.instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE;
    // A disposed instance has its key only, in a form without a type.
    const bool taken =
        raw.over ? dds_instance_get_key(reader_.handle(), info.instance_handle, &sample) ==
                       DDS_RETCODE_OK
                 : info.valid_data && ddsi_serdata_to_sample(data, &sample, nullptr, nullptr);
    if (taken) {
      raw.cdr.clear();
      if (info.valid_data) {
        raw.cdr.resize(ddsi_serdata_size(data));
        ddsi_serdata_to_ser(data, 0, raw.cdr.size(), raw.cdr.data());
      }
      raw.instance = info.instance_handle;
      raw.source_time_ns = info.source_timestamp;
      raw.origin = writers_->OriginOf(info.publication_handle, [&] {
        return ParticipantOf(reader_.handle(), info.publication_handle);
      });
    }
    ddsi_serdata_unref(data);
    if (taken) return true;
  }
  return false;
}

template <class T>
bool CdrReader<T>::Hears(std::uint64_t origin) const {
  std::vector<dds_instance_handle_t> writers(
      static_cast<std::size_t>(std::max(0, reader_.matched_writers())));
  const dds_return_t count =
      dds_get_matched_publications(reader_.handle(), writers.data(), writers.size());
  writers.resize(std::clamp<std::size_t>(count < 0 ? 0 : count, 0, writers.size()));
  return std::ranges::any_of(writers, [&](dds_instance_handle_t writer) {
    return ParticipantOf(reader_.handle(), writer) == origin;
  });
}

#define PALPATE_CDR_READER(T) template class CdrReader<wire::T>;
PALPATE_SERVICE_TYPES(PALPATE_CDR_READER)
#undef PALPATE_CDR_READER

}  // namespace palpate::dds
