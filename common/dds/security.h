#pragma once

#include <string>

namespace palpate::dds {

/// Returns the part of a domain's configuration that secures it (DDS Security 1.1: authentication,
/// access control, encryption), for a participant whose identity is in a folder as
/// deploy/security/identities makes it:
///   identity_ca.pem, permissions_ca.pem   the authorities that it trusts
///   cert.pem, key.pem                     its certificate; only its owner can read the key
///   governance.p7s, permissions.p7s       the rules for all, and its own permissions
/// Throws Error (file, remedy) if a file is missing or wrong (common/dds/identity.h), or if Cyclone
/// DDS has no security plugins on this host.
std::string SecurityConfig(const std::string& identity);

/// Sends the messages of Cyclone DDS to the log from now on, the same line at most once a second.
/// In a secured domain they say who was refused, and why.
void LogWhatDdsSays();

}  // namespace palpate::dds
