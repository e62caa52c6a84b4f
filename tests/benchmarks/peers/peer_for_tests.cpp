// The least library that palpate-bench peers --peers FILE can load: a tool that nothing holds.
#include "common/error.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {
namespace {

class Ghost : public Peer {
 public:
  PeerStep Step(const Pose& X_WH) override { return {X_WH, {}, 0}; }
};

}  // namespace
}  // namespace palpate::bench

extern "C" void PalpatePeers(std::vector<palpate::bench::PeerKind>& kinds) {
  using namespace palpate::bench;
  kinds.push_back({.id = "ghost",
                   .name = "Ghost",
                   .package = "",
                   .version = "1",
                   .settings = "goes where the hand is, a ball only",
                   .make = [](const PeerScene& scene, const palpate::Pose&) {
                     if (!scene.ball) throw palpate::Error("it has a ball only");
                     return std::make_unique<Ghost>();
                   }});
}
