#pragma once

#include <ctime>
#include <string>

namespace palpate::dds {

/// Checks an identity's folder (common/dds/security.h) before Cyclone DDS reads it, because Cyclone
/// DDS only says that it rejects the folder, and not why.  Checks that the key matches the
/// certificate and only its owner can read it; that the given authority issued the certificate;
/// that the permissions authority signed governance and permissions; that the governance
/// authenticates whole messages; that the permissions name the certificate's subject; and that all
/// of them are valid now.
/// Throws Error, with the file and the remedy.
/// @param now  wall-clock time against which the dates are checked; Cyclone DDS uses it, too.
void CheckIdentity(const std::string& identity, std::time_t now);

}  // namespace palpate::dds
