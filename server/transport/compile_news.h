#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/dds/endpoint.h"

namespace palpate {

/// Publishes to viewers, twice a second, the progress of a scene that is compiled before a server
/// serves it, as long as this object exists.
class CompileNews {
 public:
  /// Publishes nothing if the participant's identity is not permitted to.
  explicit CompileNews(const dds::Participant& service_domain);

  void Tell(const std::string& scene, std::string_view stage, double done, std::int64_t now_ns);

 private:
  dds::Writer<wire::SceneProgress> writer_;
  wire::SceneProgress last_{};
  std::int64_t told_ns_ = 0;
};

}  // namespace palpate
