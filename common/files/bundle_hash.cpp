#include "common/files/bundle_hash.h"

#include <cinttypes>
#include <cstdio>

#define XXH_INLINE_ALL  // so that programs need not link its library
#include <xxhash.h>

#include "common/error.h"

namespace palpate {

std::uint64_t BundleHash(std::span<const std::uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

void CheckBundleHash(std::span<const std::uint8_t> bytes, std::uint64_t hash,
                     const std::string& source) {
  const std::uint64_t found = BundleHash(bytes);
  if (found == hash) return;
  char text[128];
  std::snprintf(text, sizeof text,
                ": its bytes have the hash %016" PRIx64 ", and not %016" PRIx64 " as is said of it",
                found, hash);
  throw Error(source + text + ": it is damaged or forged; copy it again from its source");
}

}  // namespace palpate
