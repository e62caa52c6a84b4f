#pragma once

#include <string>

#include <dds/dds.h>

#include "common/dds/network.h"
#include "common/dds/ports.h"

namespace palpate::dds {

/// dds_create_domain, which where this host alone is meant hears this host alone.  Cyclone DDS
/// sends by the one interface that it is given, and receives by all: its sockets have no address of
/// their own, and whoever reaches another interface of this host could say what he likes in the
/// domain, though he hears nothing.  A filter in the kernel drops what did not come by `lo`; by the
/// interface, not by the sender's address, for `lo` may have others than 127.0.0.1.
///
/// The filter comes a fraction of a millisecond after the socket.  What strangers say meanwhile
/// finds no reader, for nothing is in the domain yet, and later nothing of theirs comes in.
/// @param ports  of the domain.
/// Returns what dds_create_domain does.  Throws Error where the kernel takes no filter,
/// std::bad_alloc where there is no memory for a domain.
dds_entity_t OpenDomain(dds_domainid_t id, const std::string& config, const Network& network,
                        const PortRange& ports);

}  // namespace palpate::dds
