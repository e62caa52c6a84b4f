#include "client/viewer/options.h"

#include <filesystem>

#include <CLI/CLI.hpp>
#include <boost/asio/ip/address.hpp>

#include "common/command_line.h"
#include "common/dds/participant.h"
#include "common/error.h"
#include "common/project_files.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Shows what happens at a palpate-server to browsers: serves the web page, and on the same port a
WebSocket that speaks the Foxglove protocol (messages cdr, schemas omgidl).  Prints a line that
begins with 'ready', with the page's address.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-viewer --http 8765
      the page at http://127.0.0.1:8765/, for this host alone; the desktop applications of
      Foxglove and Lichtblick attach to ws://127.0.0.1:8765/, and look
  palpate-viewer --http 8765 --allow-origin https://app.foxglove.dev
      Foxglove's web application may attach, too
  palpate-viewer --http 8765 --bind 0.0.0.0 --max-mice 0 --no-steering
      for a class in the same network: all may look, nobody may take a tool with the mouse, nor steer
      a replay; a second gateway, for the teacher's own host alone, may
  palpate-viewer --http 8765 --network eth0
      of a server on another host, which runs with --network too

Each viewer has a queue of its own that holds the newest messages only: one that stalls loses
frames and disturbs nobody.  GET /healthz tells how it goes, GET /scene/NAME.bundle gives a scene.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

}  // namespace

bool IsLoopback(const std::string& address) {
  boost::system::error_code error;
  const auto parsed = boost::asio::ip::make_address(address, error);
  return !error && parsed.is_loopback();
}

std::optional<ViewerOptions> ParseViewerOptions(int argc, const char* const* argv) {
  ViewerOptions options;
  options.page = PlaceOf(ProjectFile::kPage);
  CLI::App app(kAbout, "palpate-viewer");
  app.footer(kExamples);
  app.add_option("--http", options.port, "port of page and WebSocket; 0: a free one")
      ->required()
      ->check(CLI::Range(0, 65535));
  app.add_option("--bind", options.address,
                 "address to listen at; 0.0.0.0: every network of this host")
      ->capture_default_str();
  const CLI::Option* page =
      app.add_option("--page", options.page, "folder of the built page")->capture_default_str();
  app.add_option("--rate", options.rate_hz, "tool states a second and station, for each viewer")
      ->check(CLI::Range(10.0, 60.0))
      ->capture_default_str();
  app.add_option("--max-viewers", options.max_viewers, "viewers at once; more are turned away")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--max-mice", options.max_mice,
                 "tools that viewers may hold with the mouse, at once; 0: none")
      ->check(CLI::Range(0, 16))
      ->capture_default_str();
  app.add_flag(
      "--no-steering", options.no_steering,
      "viewers see a replay and cannot steer it from here; palpate-replay --locked rules it "
      "out for every gateway");
  app.add_option("--allow-origin", options.origins,
                 "another page that may attach and take a tool, as https://app.example.org; *: any "
                 "page; this gateway's own, and programs that are no page, always may; "
                 "file://, as desktop applications call themselves, may look unless it is named");
  app.add_option("--transport", options.transport, "of the mice's stations: auto, shm or udp")
      ->capture_default_str();
  AddNetworkOptions(app, "the server", options.network);
  AddCommonOptions(app, "which server: the same number as there", options.domain,
                   options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (page->count() > 0 && !std::filesystem::is_directory(options.page)) {
    throw UsageError("--page " + options.page +
                     ": there is no such folder; give the one that the target 'page' builds "
                     "(build/page), or leave it out");
  }
  boost::system::error_code error;
  boost::asio::ip::make_address(options.address, error);
  if (error) {
    throw UsageError("--bind '" + options.address +
                     "' is no address; give one in numbers, as 127.0.0.1 or 0.0.0.0");
  }
  dds::ParseTransport(options.transport);  // throws
  return options;
}

}  // namespace palpate
