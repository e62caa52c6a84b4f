#pragma once

namespace palpate::test {

/// Returns a `--domain` that no other test or running program on this host uses, a new one with
/// each call.  It is reserved until this process ends, by a UDP port, so that the reservation holds
/// for all processes that share the domain's ports, in any folder, container or chroot.
int OwnDomain();

}  // namespace palpate::test
