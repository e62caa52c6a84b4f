#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace palpate {

/// XXH3 (64 bits) of a scene bundle's bytes: what SceneBundle.hash names a scene by.
std::uint64_t BundleHash(std::span<const std::uint8_t> bytes);

/// For wherever a bundle comes in with its hash: throws Error where that is not the hash of its
/// bytes, so that none is taken for another.
/// @param source  names the bundle in the message.
void CheckBundleHash(std::span<const std::uint8_t> bytes, std::uint64_t hash,
                     const std::string& source);

}  // namespace palpate
