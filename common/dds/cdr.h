#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/dds/wire.h"

namespace palpate::dds {

// Conversion between samples and bytes: CDR (XCDR1, little-endian) behind the 4-byte encapsulation
// header, as DDS puts them on the wire and recordings keep them.  A sample that came through shared
// memory was never serialised, so all are serialised here.  Needs no participant.

/// Appends the sample's bytes to `out`.  T is a type of common/dds/wire.h.
template <class T>
void ToCdr(const T& sample, std::vector<std::uint8_t>& out);

/// Reads a sample from its bytes; false if they are not those of a T.  The sample must own
/// nothing before; afterwards the caller must free what it owns (SceneBundle's bytes) with
/// FreeContents (cdr_reader.h).
template <class T>
bool FromCdr(std::span<const std::uint8_t> bytes, T& sample);

}  // namespace palpate::dds
