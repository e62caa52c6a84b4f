#pragma once

#include <cstddef>
#include <memory>

#include "client/load/frame_tally.h"
#include "client/load/options.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Viewers over WebSocket that want tool states and nothing else, as pages do: all in one event
/// loop, in a thread of its own.
class WebViewers {
 public:
  /// Returns when all are attached and have subscribed, or `stop` has come.  Throws Error where no
  /// gateway answers, or it wants no more.
  /// @param stalled  viewers more that then read nothing.   @param tally  must outlive it.
  WebViewers(const ViewerUrl& url, std::size_t viewers, std::size_t stalled, double wait_s,
             FrameTally& tally, StopSignal& stop);
  /// Ends the thread; nothing is added to the tally any more.
  ~WebViewers();
  WebViewers(const WebViewers&) = delete;
  WebViewers& operator=(const WebViewers&) = delete;

  /// Viewers whose socket has ended by itself.
  std::size_t gone() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
