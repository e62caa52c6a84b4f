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

/// A block as it is to be published.  `sample.surface` is empty: what it holds is in `surface`.
struct SolidBlockNews {
  wire::SolidBlock sample{};
  std::vector<std::uint8_t> surface;
};

/// What viewers are shown of what burs left of a scene's solids, block by block.
///
/// Loops tell blocks as their burs change them; the surface of each, and of the 26 round it, is
/// made here and told where it is another than it was.  What is under the bur changes in each step
/// and is hidden by it: a block is told once the bur has left it, and meanwhile a few times a
/// second.  A bur that is too quick for the bytes that a viewer may cost is seen later and not
/// less.
///
/// Thread contract: service thread.
class SolidChanges {
 public:
  /// A block that has not changed for so long is told, and one that changes after so long.
  static constexpr std::int64_t kLeft_ns = 20'000'000, kUnderBur_ns = 400'000'000;
  /// What a viewer may cost: 600 kbit/s.
  static constexpr double kBytesPerSecond = 75e3, kBytesAtOnce = 10e3;
  /// Surfaces that one poll may make: some 40 us each.
  static constexpr int kMostAtOnce = 24;

  /// The solids, and what all burs took of them, outlive this.
  SolidChanges(std::span<const CutSolid> solids, const std::vector<CutField>& cuts);

  /// A block has changed.
  void Take(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns);
  /// All is there again, and is no news.
  void MakeWhole();

  /// A block that could not be published: it waits again.
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns);
  /// Adds what is to be published now; scene and server are left to the caller.
  /// @param count  of the scene's changes: each gets the next number.
  void AddNews(std::int64_t now_ns, std::uint64_t& count, std::vector<SolidBlockNews>& news);

 private:
  struct Times {
    std::int64_t first_ns, last_ns;  ///< of the changes that nobody has been told of
  };
  struct Solid {
    const CutSolid* solid;
    const CutField* cut;
    std::map<std::uint32_t, Times> waiting{};       ///< of blocks
    std::map<std::uint32_t, std::uint64_t> told{};  ///< of a block: hash of what was published
  };
  struct Place {
    std::size_t solid;
    std::uint32_t block;
  };

  void Wait(const Place& place, std::int64_t now_ns);
  bool Tell(const Place& place, SolidBlockNews& news);

  std::vector<Solid> solids_;
  std::list<Place> line_;  // those that wait, the first to begin in front
  TokenBucket bytes_{kBytesPerSecond, kBytesAtOnce};
  SolidSurface surface_;
};

}  // namespace palpate
