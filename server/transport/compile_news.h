#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/dds/endpoint.h"

namespace palpate {

/// Tells viewers how far a scene is that is compiled before a server serves any: twice a second, as
/// long as this object lives.
class CompileNews {
 public:
  /// Where the identity may not say it, it is not said.
  explicit CompileNews(const dds::Participant& service_domain);

  void Tell(const std::string& scene, std::string_view stage, double done, std::int64_t now_ns);

 private:
  dds::Writer<wire::SceneProgress> writer_;
  wire::SceneProgress last_{};
  std::int64_t told_ns_ = 0;
};

}  // namespace palpate
