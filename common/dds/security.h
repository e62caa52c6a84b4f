#pragma once

#include <string>

namespace palpate::dds {

/// The part of a domain's configuration that makes it secured (DDS Security 1.1: authentication,
/// access control, encryption), for a participant whose identity stands in a folder, as
/// deploy/security/identities makes it:
///   identity_ca.pem, permissions_ca.pem   whom it trusts
///   cert.pem, key.pem                     who it is; the key is its owner's alone
///   governance.p7s, permissions.p7s       what holds for all, and what it may do
/// Throws Error (file, remedy) where one is missing or not what it must be (common/dds/identity.h),
/// or where Cyclone DDS has no security plugins here.
std::string SecurityConfig(const std::string& identity);

/// From now on what Cyclone DDS has to say goes to the log, no line twice a second: in a secured
/// domain it is who was refused, and why.
void LogWhatDdsSays();

}  // namespace palpate::dds
