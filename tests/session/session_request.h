#pragma once

#include <cstdint>
#include <string>

#include "common/dds/wire.h"

namespace palpate::test {

inline wire::SessionRequest MakeRequest(const std::string& station, std::uint64_t run,
                                        const std::string& scene, const std::string& tool = "",
                                        bool leave = false) {
  wire::SessionRequest request{};
  wire::FromText(station, request.station);
  request.run = run;
  wire::FromText(scene, request.scene);
  wire::FromText(tool, request.tool);
  request.leave = leave;
  return request;
}

}  // namespace palpate::test
