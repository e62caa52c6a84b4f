#pragma once

#include <ctime>
#include <string>

namespace palpate::dds {

/// Looks at an identity's folder (common/dds/security.h) before Cyclone DDS does, which says of all
/// that is wrong there no more than that it does not take it: the key is its owner's alone and the
/// certificate's, the certificate is the given authority's, governance and permissions are signed
/// by theirs, the governance has messages authenticated whole, the permissions are for the
/// certificate's subject, and all hold now.
/// Throws Error, with the file and what to do.
/// @param now  the wall clock's, by which the dates are judged; Cyclone DDS goes by it, too.
void CheckIdentity(const std::string& identity, std::time_t now);

}  // namespace palpate::dds
