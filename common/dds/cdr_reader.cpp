#include "common/dds/cdr_reader.h"

#include <dds/ddsi/ddsi_serdata.h>

namespace palpate::dds {

template <class T>
bool CdrReader<T>::Take(CdrSample& raw, T& sample) {
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  while (dds_takecdr(reader_.handle(), &data, 1, &info, DDS_ANY_STATE) == 1) {
    FreeContents(sample);
    const bool taken = info.valid_data && ddsi_serdata_to_sample(data, &sample, nullptr, nullptr);
    if (taken) {
      raw.cdr.resize(ddsi_serdata_size(data));
      ddsi_serdata_to_ser(data, 0, raw.cdr.size(), raw.cdr.data());
      raw.instance = info.instance_handle;
      raw.source_time_ns = info.source_timestamp;
    }
    ddsi_serdata_unref(data);
    if (taken) return true;
  }
  return false;
}

template class CdrReader<wire::SessionRequest>;
template class CdrReader<wire::SessionState>;
template class CdrReader<wire::SceneChange>;
template class CdrReader<wire::LeafTaken>;
template class CdrReader<wire::WholeRequest>;
template class CdrReader<wire::SceneWhole>;
template class CdrReader<wire::ReplayContents>;
template class CdrReader<wire::ReplayState>;
template class CdrReader<wire::ReplayRequest>;
template class CdrReader<wire::OperateRequest>;
template class CdrReader<wire::ToolState>;
template class CdrReader<wire::LoopStatistics>;
template class CdrReader<wire::StationStatistics>;
template class CdrReader<wire::SceneBundle>;
template class CdrReader<wire::SceneOffer>;
template class CdrReader<wire::GuideTarget>;

}  // namespace palpate::dds
