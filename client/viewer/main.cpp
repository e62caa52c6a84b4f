#include <cstdio>

#include <spdlog/spdlog.h>

#include "client/viewer/gateway.h"
#include "client/viewer/options.h"
#include "client/viewer/tokens.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/stop_signal.h"

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-viewer", [&] {
    const auto options = palpate::ParseViewerOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-viewer", options->log_level);
    if (options->make_token) {
      const auto& [role, name] = *options->make_token;
      std::printf("%s\n", palpate::MakeToken(options->tokens, role, name).c_str());
      spdlog::info(
          "'{}' may {}; its token stands nowhere else, so keep it.  The page is opened with "
          "#token=TOKEN at the end of its address; gateways that run read {} anew at "
          "SIGHUP (systemctl reload palpate-viewer)",
          name, palpate::RoleName(role), options->tokens);
      return 0;
    }
    palpate::StopSignal stop;
    palpate::RunGateway(*options, stop);
    return 0;
  });
}
