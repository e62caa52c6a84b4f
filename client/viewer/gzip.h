#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace palpate {

/// The bytes as a gzip file, at zlib's fastest level.  Takes 20 ms a megabyte.  Throws Error where
/// memory is lacking.
std::vector<std::uint8_t> Gzip(std::span<const std::uint8_t> bytes);

}  // namespace palpate
