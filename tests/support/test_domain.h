#pragma once

namespace palpate::test {

/// A `--domain` that nobody else on this host has: no other test, of this run or of another, and no
/// program that is at work.  Held until this process ends; another with each call.
/// It is claimed by a UDP port, so that those who share the domain's ports share its claim too, in
/// whichever folder, container or chroot they are.
int OwnDomain();

}  // namespace palpate::test
