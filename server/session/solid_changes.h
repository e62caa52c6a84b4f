#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "common/realtime/token_bucket.h"
#include "scenes/grid/solid_surface.h"
#include "server/physics/cut/cutting.h"
#include "server/session/cut_block.h"

namespace palpate {

/// A block as it is to be published.  `sample.surface` is empty: what it holds is in `surface`.
struct SolidBlockNews {
  wire::SolidBlock sample{};
  std::vector<std::uint8_t> surface;
};

/// What burs left of a scene's solids: what viewers are shown, block by block, and what the next
/// session begins with.
///
/// A loop tells blocks as its bur changes them; the surface of each, and of the 26 round it, is
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

  /// The solids outlive this.
  explicit SolidChanges(std::span<const CutSolid> solids);

  void Take(const CutBlock& block, std::int64_t now_ns);
  /// A loop that no pose comes to any more leaves its cuts here.
  void Keep(std::vector<CutField> cuts, std::int64_t now_ns);
  /// What the last loop left; empty: all is there.
  const std::vector<CutField>& kept() const { return kept_; }
  bool is_whole() const { return whole_; }
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
    explicit Solid(const CutSolid& s);
    const CutSolid* solid;
    SparseField field;                            ///< phi_c, as loops have told it
    std::map<std::uint32_t, Times> waiting;       ///< of blocks
    std::map<std::uint32_t, std::uint64_t> told;  ///< of a block: hash of what was published
  };
  struct Place {
    std::size_t solid;
    std::uint32_t block;
  };

  void Wait(const Place& place, std::int64_t now_ns);
  void WaitRound(std::size_t solid, std::uint32_t block, std::int64_t now_ns);
  bool Tell(const Place& place, SolidBlockNews& news);

  std::vector<Solid> solids_;
  std::list<Place> line_;  // those that wait, the first to begin in front
  TokenBucket bytes_{kBytesPerSecond, kBytesAtOnce};
  std::vector<CutField> kept_;
  SolidSurface surface_;
  bool whole_ = true;
};

}  // namespace palpate
