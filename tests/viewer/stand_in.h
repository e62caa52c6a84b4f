#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/files/bundle_hash.h"
#include "tests/support/test_domain.h"
#include "tests/viewer/viewer_program.h"

namespace palpate::test {

/// Of all tests of this program.
inline const int kDomain = OwnDomain();

/// The real gateway, in that domain.
struct Gateway : ViewerProgram {
  explicit Gateway(std::vector<std::string> more = {}) : ViewerProgram(kDomain, std::move(more)) {}
  /// It has logged this by now, or does so before long.
  bool Logs(const std::string& text) {
    for (int i = 0; i < 500; ++i) {
      if (program().Output().find(text) != std::string::npos) return true;
      usleep(10'000);
    }
    return false;
  }
};

/// Says that there is a scene, and notes who wants to drive a tool of it.
class StandIn {
 public:
  StandIn() {
    static std::uint8_t byte = 1;
    wire::SceneBundle bundle{};
    wire::FromText("cube", bundle.scene);
    bundle.server_run = kRun;
    bundle.hash = BundleHash({&byte, 1});
    bundle.bundle._buffer = &byte;
    bundle.bundle._length = bundle.bundle._maximum = 1;
    EXPECT_TRUE(bundles_.Write(bundle));
  }
  std::optional<wire::OperateRequest> Asked() {
    wire::OperateRequest request{};
    for (int i = 0; i < 2000; ++i) {
      if (operations_.Take(request)) return request;
      usleep(10'000);
    }
    return std::nullopt;
  }
  /// How many more have come by the time that none has come for a fifth of a second.
  int CountAsked() {
    wire::OperateRequest request{};
    int count = 0;
    for (int quiet = 0; quiet < 20;) {
      if (operations_.Take(request)) {
        ++count;
        quiet = 0;
      } else {
        usleep(10'000);
        ++quiet;
      }
    }
    return count;
  }

  static constexpr std::uint64_t kRun = 0x1234;

 private:
  dds::Participant participant_ = dds::Participant::Service(kDomain);
  // By which a server is known to live; before the others, as a server has it.
  dds::Writer<wire::SessionState> states_{participant_, dds::kSessionStateTopic,
                                          dds::Qos::kSession};
  dds::Writer<wire::SceneBundle> bundles_{participant_, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::Reader<wire::OperateRequest> operations_{participant_, dds::kOperateRequestTopic,
                                                dds::Qos::kRecordSession};
};

}  // namespace palpate::test
