#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace palpate {

/// Returns the XXH3 hash (64 bits) of a scene bundle's bytes, by which SceneBundle.hash identifies
/// a scene.
std::uint64_t BundleHash(std::span<const std::uint8_t> bytes);

/// Checks a bundle that arrives with its hash: throws Error if the hash is not that of its bytes.
/// @param source  names the bundle in the message.
void CheckBundleHash(std::span<const std::uint8_t> bytes, std::uint64_t hash,
                     const std::string& source);

}  // namespace palpate
