#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/dds/wire.h"

namespace palpate::dds {

// Samples as bytes: CDR (XCDR1, little-endian) behind the four bytes that name the encoding, as DDS
// puts them on the wire and recordings keep them.  A sample that came through shared memory has no
// such bytes of its own, so all are made here.  Needs no participant.

/// Appends the sample's bytes.  T is a type of common/dds/wire.h.
template <class T>
void ToCdr(const T& sample, std::vector<std::uint8_t>& out);

/// False where the bytes are not those of a T.  The sample must own nothing; what it owns then
/// (SceneBundle's bytes) is the caller's: FreeContents (cdr_reader.h).
template <class T>
bool FromCdr(std::span<const std::uint8_t> bytes, T& sample);

}  // namespace palpate::dds
