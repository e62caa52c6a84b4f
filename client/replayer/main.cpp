#include <variant>

#include "client/replayer/options.h"
#include "common/files/private_file.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

int Run(const ReplayOptions& options) {
  KeepFilesPrivate();
  return std::visit([](const auto& command) { return command.Run(); }, options.command);
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-replay", argc, argv, palpate::ParseReplayOptions,
                             palpate::Run);
}
