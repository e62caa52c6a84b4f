#include "common/dds/cdr.h"

#include <array>
#include <cstring>

#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/ddsi_serdata_default.h>

namespace palpate::dds {
namespace {

constexpr std::array<std::uint8_t, 4> kLittleEndian = {0, 1, 0, 0};

template <class T>
constexpr bool kIsPayload = std::is_same_v<T, wire::HapticPose> || std::is_same_v<T, wire::Wrench>;

/// The parts of a type's descriptor that the stream functions use.
template <class T>
ddsi_sertype_default TypeOf() {
  ddsi_sertype_default type{};
  type.type.size = wire::Descriptor<T>().m_size;
  type.type.ops.nops = wire::Descriptor<T>().m_nops;
  type.type.ops.ops = const_cast<std::uint32_t*>(wire::Descriptor<T>().m_ops);
  return type;
}

}  // namespace

template <class T>
void ToCdr(const T& sample, std::vector<std::uint8_t>& out) {
  out.insert(out.end(), kLittleEndian.begin(), kLittleEndian.end());
  if constexpr (kIsPayload<T>) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&sample);
    out.insert(out.end(), bytes, bytes + sizeof sample);
  } else {
    dds_ostream_t stream;
    dds_ostream_init(&stream, 0, 1);
    dds_stream_write(&stream, reinterpret_cast<const char*>(&sample), wire::Descriptor<T>().m_ops);
    out.insert(out.end(), stream.m_buffer, stream.m_buffer + stream.m_index);
    dds_ostream_fini(&stream);
  }
}

template <class T>
bool FromCdr(std::span<const std::uint8_t> bytes, T& sample) {
  // The last two bits of the options give the number of padding bytes at the payload's end.
  if (bytes.size() < kLittleEndian.size() || bytes[0] != 0 || bytes[1] != 1) return false;
  const std::size_t fill = bytes[3] & 3u;
  if (bytes.size() < kLittleEndian.size() + fill) return false;
  const auto payload = bytes.subspan(4, bytes.size() - 4 - fill);
  if constexpr (kIsPayload<T>) {
    if (payload.size() != sizeof sample) return false;
    std::memcpy(&sample, payload.data(), sizeof sample);
  } else {
    // A copy, because the check may write to the bytes: it also converts a foreign byte order.
    std::vector<char> copy(payload.begin(), payload.end());
    std::uint32_t size = 0;
    const auto count = static_cast<std::uint32_t>(copy.size());
    if (copy.size() != count || copy.empty() ||
        dds_stream_normalize_data(copy.data(), &size, count, false, 1,
                                  wire::Descriptor<T>().m_ops) == nullptr) {
      return false;
    }
    const ddsi_sertype_default type = TypeOf<T>();
    dds_istream_t stream;
    dds_istream_init(&stream, size, copy.data(), 1);
    dds_stream_read_sample(&stream, &sample, &type);
    dds_istream_fini(&stream);
  }
  return true;
}

#define PALPATE_CDR(T)                                             \
  template void ToCdr(const wire::T&, std::vector<std::uint8_t>&); \
  template bool FromCdr(std::span<const std::uint8_t>, wire::T&);
PALPATE_LOOP_TYPES(PALPATE_CDR)
PALPATE_SERVICE_TYPES(PALPATE_CDR)
#undef PALPATE_CDR

}  // namespace palpate::dds
