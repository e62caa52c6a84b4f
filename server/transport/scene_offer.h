#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "common/dds/wire.h"
#include "server/offer/served_scene.h"

namespace palpate {

/// What a server offers, as a sample; owns what the sample's sequences point to.
class SceneOffer {
 public:
  SceneOffer(const std::vector<ServedScene>& scenes, std::uint64_t server_run);
  SceneOffer(const SceneOffer&) = delete;
  SceneOffer& operator=(const SceneOffer&) = delete;

  const wire::SceneOffer& sample() const { return sample_; }

 private:
  void Add(const ServedScene& scene);
  /// Fills a sequence of the sample's.
  template <class Sequence>
  void AddHand(const std::vector<PoseScript::Key>& hand, Sequence& sequence);

  std::deque<std::vector<wire::HandKey>> hands_;
  std::deque<std::vector<wire::OfferedTool>> tools_;
  std::vector<wire::OfferedScene> scenes_;
  wire::SceneOffer sample_{};
};

}  // namespace palpate
