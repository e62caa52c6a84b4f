#pragma once

#include <cstddef>
#include <memory>

#include "client/load/frame_tally.h"
#include "client/load/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Viewers over WebSocket that subscribe to tool states only, as pages do.  All run in one event
/// loop, in a thread of its own.
class WebViewers {
 public:
  /// Returns when all viewers are connected and have subscribed, or when `stop` comes.  Throws
  /// Error if no gateway answers, or it accepts no more viewers.
  /// @param tally  must outlive it.
  WebViewers(const ViewerUrl& url, std::size_t viewers, double wait_s, FrameTally& tally,
             StopSignal& stop);
  /// Ends the thread; nothing is added to the tally after that.
  ~WebViewers();
  WebViewers(const WebViewers&) = delete;
  WebViewers& operator=(const WebViewers&) = delete;

  /// Returns the number of viewers whose connection ended without our closing it.
  std::size_t gone() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
