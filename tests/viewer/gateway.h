#pragma once

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/files/bundle_hash.h"
#include "tests/support/eventually.h"
#include "tests/support/program.h"
#include "tests/support/test_domain.h"
#include "tests/support/web_client.h"

namespace palpate::test {

inline constexpr const char* kV1 = "foxglove.websocket.v1";
/// The domain of all tests of this program.
inline const int kDomain = OwnDomain();

/// The real palpate-viewer, at a port of its own in that domain, while the object lives.
class Gateway {
 public:
  using Headers = std::map<std::string, std::string>;

  explicit Gateway(const std::vector<std::string>& more = {})
      : program_(PALPATE_BIN_DIR "/palpate-viewer",
                 Joined({"--http", "0", "--transport", "udp", "--domain", std::to_string(kDomain)},
                        more)) {
    EXPECT_TRUE(program_.Says("/; domain")) << program_.Output();
    const std::string& said = program_.Output();
    port_ = std::atoi(said.c_str() + said.rfind(':', said.find("/; domain")) + 1);
  }

  int port() const { return port_; }
  Program& program() { return program_; }
  nlohmann::json Health(const Headers& headers = {}) {
    return nlohmann::json::parse(Get(port_, "/healthz", headers).body);
  }
  /// Polls the health until the condition holds.
  bool Until(const std::function<bool(const nlohmann::json&)>& condition,
             const Headers& headers = {}) {
    return Eventually([&] { return condition(Health(headers)); });
  }
  bool HasViewers(int count, const Headers& headers = {}) {
    return Until([&](const nlohmann::json& health) { return health["viewers"] == count; }, headers);
  }
  bool KnowsScenes(std::size_t count, const Headers& headers = {}) {
    return Until([&](const nlohmann::json& health) { return health["scenes"].size() == count; },
                 headers);
  }
  /// Whether it logs `text` within five seconds, or has done so.
  bool Logs(const std::string& text) {
    return Eventually([&] { return program_.Output().find(text) != std::string::npos; }, 5.0);
  }

 private:
  Program program_;
  int port_ = 0;
};

/// Announces a scene as a server does, and receives the wishes that concern it.
class StandIn {
 public:
  /// @param seats  number of the scene's seats.
  explicit StandIn(int seats = 0, const std::string& scene = "cube") {
    static std::uint8_t byte = 1;
    wire::SceneBundle bundle{};
    wire::FromText(scene, bundle.scene);
    bundle.server_run = kRun;
    bundle.hash = BundleHash({&byte, 1});
    bundle.bundle._buffer = &byte;
    bundle.bundle._length = bundle.bundle._maximum = 1;
    EXPECT_TRUE(bundles_.Write(bundle));
    bundle.bundle = {};
    for (int seat = 1; seat <= seats; ++seat) {
      wire::FromText(scene + "-" + std::to_string(seat), bundle.scene);
      EXPECT_TRUE(bundles_.Write(bundle));
    }
  }
  std::optional<wire::OperateRequest> Asked() {
    wire::OperateRequest request{};
    return Eventually([&] { return operations_.Take(request); }) ? std::optional(request)
                                                                 : std::nullopt;
  }
  /// The next wish to make a scene whole.
  std::optional<wire::WholeRequest> Wished() {
    wire::WholeRequest request{};
    return Eventually([&] { return wishes_.Take(request); }) ? std::optional(request)
                                                             : std::nullopt;
  }
  /// Tells that somebody else has restored the scene.
  void TellWhole(const std::string& scene, const std::string& by) {
    wire::SceneWhole whole{};
    wire::FromText(scene, whole.scene);
    wire::FromText(by, whole.by);
    whole.server_run = kRun;
    whole.request = 77;
    EXPECT_TRUE(wholes_.Write(whole));
  }
  /// How many wishes come until none has come for a fifth of a second.
  int CountAsked() {
    wire::OperateRequest request{};
    int count = 0;
    while (Eventually([&] { return operations_.Take(request); }, 0.2)) ++count;
    return count;
  }

  static constexpr std::uint64_t kRun = 0x1234;

 private:
  dds::Participant participant_ = dds::Participant::Service(kDomain);
  // Shows that a server lives; made before the others, as in a server.
  dds::Writer<wire::SessionState> states_{participant_, dds::kSessionStateTopic,
                                          dds::Qos::kSession};
  dds::Writer<wire::SceneBundle> bundles_{participant_, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::Writer<wire::SceneWhole> wholes_{participant_, dds::kSceneWholeTopic, dds::Qos::kSession};
  dds::Reader<wire::OperateRequest> operations_{participant_, dds::kOperateRequestTopic,
                                                dds::Qos::kRecordSession};
  dds::Reader<wire::WholeRequest> wishes_{participant_, dds::kWholeRequestTopic,
                                          dds::Qos::kRecordSession};
};

}  // namespace palpate::test
