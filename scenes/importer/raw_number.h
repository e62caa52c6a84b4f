#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace palpate {

static_assert(std::endian::native == std::endian::little);

template <class T>
double ReadRaw(const char* at) {
  T number;
  std::memcpy(&number, at, sizeof number);
  return static_cast<double>(number);
}

/// A type of the numbers in binary mesh files.
struct RawType {
  std::size_t bytes;
  double one;  ///< what stands for 1 where whole numbers are normalised
  double (*read)(const char* at);
};

/// In the order of glTF's component types.
inline constexpr RawType kRawTypes[] = {{1, 127, ReadRaw<std::int8_t>},
                                        {1, 255, ReadRaw<std::uint8_t>},
                                        {2, 32767, ReadRaw<std::int16_t>},
                                        {2, 65535, ReadRaw<std::uint16_t>},
                                        {4, 2147483647.0, ReadRaw<std::int32_t>},
                                        {4, 4294967295.0, ReadRaw<std::uint32_t>},
                                        {4, 1, ReadRaw<float>},
                                        {8, 1, ReadRaw<double>}};

}  // namespace palpate
