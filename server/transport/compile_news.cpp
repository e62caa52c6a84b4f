#include "server/transport/compile_news.h"

#include <spdlog/spdlog.h>

#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate {
namespace {

constexpr std::int64_t kEvery_ns = 500'000'000;

}  // namespace

CompileNews::CompileNews(const dds::Participant& service_domain) {
  try {
    writer_ = {service_domain, dds::kSceneProgressTopic, dds::Qos::kSession};
  } catch (const Error& error) {
    spdlog::info("viewers do not see the progress of scenes: {}", error.what());
  }
}

void CompileNews::Tell(const std::string& scene, std::string_view stage, double done,
                       std::int64_t now_ns) {
  const bool another = scene != last_.scene;
  if (!writer_ || (!another && now_ns - told_ns_ < kEvery_ns)) return;
  told_ns_ = now_ns;
  wire::FromText(scene, last_.scene);
  wire::FromText(std::string(stage), last_.stage);
  last_.done = done;
  writer_.Write(last_);
}

}  // namespace palpate
