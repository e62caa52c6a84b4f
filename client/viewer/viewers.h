#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "client/viewer/refusal_log.h"
#include "client/viewer/viewer.h"
#include "client/viewer/viewer_places.h"
#include "client/viewer/wish_limits.h"

namespace palpate {

/// The viewers that are connected: their places, the frames that they are sent, and how often they
/// may have a wish.
/// Thread contract: the network thread.
class Viewers {
 public:
  struct Traffic {
    std::uint64_t taken = 0;  ///< frames
    std::uint64_t sent = 0;
    std::uint64_t bytes = 0;
    std::uint64_t lost = 0;  ///< also by viewers that have left
  };

  explicit Viewers(std::size_t most);

  /// Tells a client whether it has come back to the same gateway.
  const std::string& session_id() const { return session_id_; }
  const std::map<std::uint64_t, std::shared_ptr<Viewer>>& all() const { return all_; }
  /// Returns whether there is room for one more viewer of this address; another may be
  /// dropped for it.
  bool MakeRoom(const std::string& address);
  void Join(const std::shared_ptr<Viewer>& viewer);
  void Leave(const Viewer& viewer);
  ViewerPlaces& places() { return places_; }
  /// Returns why a viewer may not have this wish now; empty: it may.  A wish that comes too often
  /// is logged, and the viewer is told once.
  std::string Refuse(Wish wish, Viewer& viewer, std::int64_t now_ns);
  RefusalLog& refusals() { return refusals_; }

  /// Gives all viewers a frame that has arrived.
  void Distribute(const FramePtr& frame, std::int64_t now_ns);
  /// Sends what is due, and drops those that are gone.
  void Tick(std::int64_t now_ns);
  void CountSent(std::size_t bytes);
  Traffic traffic() const;

 private:
  const std::string session_id_;
  std::map<std::uint64_t, std::shared_ptr<Viewer>> all_;  // by id
  ViewerPlaces places_;
  WishLimits wishes_;
  RefusalLog refusals_;
  Traffic traffic_;  // lost: of those that have left
};

}  // namespace palpate
