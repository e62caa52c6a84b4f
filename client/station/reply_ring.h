#pragma once

#include "client/station/reply.h"
#include "common/realtime/ring.h"

namespace palpate {

/// Replies on their way from DDS's receiving thread to the servo thread: a quarter of a second of
/// them.  A ring and not a mailbox: when two replies come within a tick, the older is late, not
/// lost, and is counted so.  Where it is full, the servo thread has not read for that long: its
/// device renders nothing then, whatever comes.
using ReplyRing = Ring<Reply, 256>;

}  // namespace palpate
