#include "client/igtl/options.h"

#include <CLI/CLI.hpp>

#include "common/program/command_line.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Gives the poses and forces of all tools to 3D Slicer and others by OpenIGTLink: for each station a
TRANSFORM (millimetres, RAS), and SENSORs STATION_force (N) and STATION_torque (N m).
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-igtl
      then in 3D Slicer: SlicerOpenIGTLink, a connector of type client to localhost, port 18944
  palpate-igtl --bind 0.0.0.0 --rate 30
      for other hosts, thirty times a second

The scene's axes become Slicer's: x to the left, y up, z forward.  What a client sends is
ignored.  A slow client gets fewer messages; one that takes none for 10 s is disconnected.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

}  // namespace

std::optional<IgtlOptions> ParseOptions(int argc, const char* const* argv) {
  IgtlOptions options;
  CLI::App app(kAbout, "palpate-igtl");
  app.footer(kExamples);
  app.add_option("--bind", options.address, "address of this host to listen at")
      ->capture_default_str();
  app.add_option("--port", options.port, "TCP port; 0: a free one, which is printed")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--rate", options.rate_Hz, "messages a second; the server itself sends 60")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  AddNetworkOptions(app, "the server", options.network);
  AddCommonOptions(app, "the server's domain: the number that it was given", options.domain,
                   options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  return options;
}

}  // namespace palpate
