#pragma once

#include <string>

#include <dds/dds.h>

#include "common/dds/network.h"
#include "common/dds/ports.h"

namespace palpate::dds {

/// Calls dds_create_domain; if the network is this host alone, the domain receives from this host
/// alone.  Cyclone DDS sends by the one interface that it is given, but receives by all of them:
/// its sockets are bound to no address, so a sender that reaches another interface of this host
/// could inject data into the domain, though it would receive nothing.  A filter in the kernel
/// drops packets that did not come by `lo`.  It tests the interface and not the sender's address,
/// because `lo` may have other addresses than 127.0.0.1.
///
/// The filter is set a fraction of a millisecond after the socket is made.  Packets that arrive in
/// between find no reader, because the domain is still empty.
/// @param ports  the ports of the domain.
/// Returns what dds_create_domain returns.  Throws Error if the kernel rejects the filter,
/// std::bad_alloc if there is no memory for a domain.
dds_entity_t OpenDomain(dds_domainid_t id, const std::string& config, const Network& network,
                        const PortRange& ports);

}  // namespace palpate::dds
