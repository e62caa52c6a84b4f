#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "common/realtime/token_bucket.h"
#include "scenes/grid/cut_field.h"
#include "scenes/grid/solid_surface.h"
#include "server/physics/cut/cutting.h"

namespace palpate {

/// A block to be published.  The sequences of `sample` are empty; they are beside it.
struct SolidBlockNews {
  wire::SolidBlock sample{};
  std::vector<std::uint8_t> surface;
  std::vector<float> removed_mm3;
};

/// Publishes to viewers, block by block, what burs left of a scene's solids.
///
/// Loops tell which blocks their burs change.  This class computes the surface of each such block
/// and of the 26 around it, and publishes those that changed.  What lies under a bur changes in
/// each step and is hidden by the bur, so a block is published once the bur has left it, and a few
/// times a second until then.  If a bur cuts faster than the bytes that a viewer may cost allow,
/// viewers see its cuts later, but completely.
///
/// Thread contract: service thread.
class SolidChanges {
 public:
  /// A block is published if it has not changed for kLeft_ns, or kUnderBur_ns
  /// after its first change.
  static constexpr std::int64_t kLeft_ns = 20'000'000, kUnderBur_ns = 400'000'000;
  /// Most bytes for a viewer: 600 kbit/s.
  static constexpr double kBytesPerSecond = 75e3, kBytesAtOnce = 10e3;
  /// Most surfaces computed in one poll, some 40 us each.
  static constexpr int kMostAtOnce = 24;

  /// `solids` and `cuts` (what all burs removed from them) must outlive this.
  SolidChanges(std::span<const CutSolid> solids, const std::vector<CutField>& cuts);

  /// Notes that a block has changed.
  void Take(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns);
  /// Restores all material; this itself is not published.
  void MakeWhole();

  /// Queues a block that could not be published.
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns);
  /// Appends what is to be published now; the caller fills in scene and server.
  /// @param count  number of the scene's changes: each gets the next number
  void AddNews(std::int64_t now_ns, std::uint64_t& count, std::vector<SolidBlockNews>& news);

 private:
  struct Times {
    std::int64_t first_ns, last_ns;  ///< of the changes that were not published yet
  };
  struct Solid {
    const CutSolid* solid;
    const CutField* cut;
    CutField whole;                            ///< of the same solid, of which nothing is cut
    std::map<std::uint32_t, Times> waiting{};  ///< by block
    std::map<std::uint32_t, std::uint64_t> published{};  ///< by block: hash of what was published
  };
  struct Place {
    std::size_t solid;
    std::uint32_t block;
  };

  void Wait(const Place& place, std::int64_t now_ns);
  bool Tell(const Place& place, SolidBlockNews& news);

  std::vector<Solid> solids_;
  std::list<Place> line_;  // blocks that wait, the first to begin in front
  TokenBucket bytes_{kBytesPerSecond, kBytesAtOnce};
  SolidSurface surface_;
};

}  // namespace palpate
