#include "client/viewer/options.h"

#include <filesystem>

#include "common/dds/participant.h"
#include "common/error.h"
#include "common/files/project_files.h"

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
  palpate-viewer --make-token operate teacher --tokens tokens.txt
  palpate-viewer --http 8765 --bind 0.0.0.0 --tokens tokens.txt --tls-cert lab.pem --tls-key lab.key \
                 --host-name lab.example
      prints a teacher's token once; then the page at https://lab.example:8765/#token=TOKEN is for
      those who have one: watch sees, drive takes tools and steers replays, operate decides about
      stations, too
  palpate-viewer --http 8765 --course anatomy
      a class: prints a teacher's link once; on the page the teacher makes people and their links
  palpate-viewer --course anatomy --export-csv anatomy.csv
      all trials of that class so far, for a spreadsheet
  palpate-viewer --http 8765 --network eth0
      of a server on another host, which runs with --network too

Each viewer has a queue of its own that holds the newest messages only: one that stalls loses
frames and disturbs nobody.  GET /healthz tells how it goes, GET /scene/NAME.bundle gives a scene.
Where all places are taken, the address that has most of them makes room for one that has fewer.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

/// As many as a server has stations.
constexpr int kMostMice = 32;

boost::asio::ip::address ToAddress(const char* flag, const std::string& text) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(text, error);
  if (error) {
    throw UsageError(std::string(flag) + " '" + text +
                     "' is no address; give one in numbers, as 127.0.0.1 or 0.0.0.0");
  }
  return address;
}

ViewerOptions::NewToken ToNewToken(const std::vector<std::string>& words, const std::string& file) {
  const auto role = ParseRole(words.at(0));
  if (!role) {
    throw UsageError("--make-token " + words[0] +
                     ": is no role; give watch, drive or operate, and a name");
  }
  if (file.empty()) {
    throw UsageError("--make-token: --tokens FILE or --course FOLDER says where it is entered");
  }
  return {*role, words.at(1)};
}

}  // namespace

std::optional<ViewerOptions> ParseViewerOptions(int argc, const char* const* argv) {
  ViewerOptions options;
  options.page = PlaceOf(ProjectFile::kPage);
  const CommandLine app(kAbout, "palpate-viewer", kExamples);
  const Option port =
      app.Add("--http", options.port, "port of the page and its WebSocket; 0: a free one")
          .Range(0, 65535);
  app.Add("--bind", options.address, "address to listen at; 0.0.0.0: all networks of this host")
      .ShowDefault();
  const Option page =
      app.Add("--page", options.page,
              "folder of the built page; default: the one of this program's package or build");
  app.Add("--rate", options.rate_hz, "updates a second that each viewer gets of each tool")
      .Range(10.0, 60.0)
      .ShowDefault();
  app.Add("--max-viewers", options.max_viewers, "viewers at once; more are refused")
      .Range(1, 10000)
      .ShowDefault();
  const Option mice = app.Add("--max-mice", options.max_mice,
                              "tools that viewers may hold with the mouse at once; 0: none.  With "
                              "a --course 32")
                          .Range(0, kMostMice)
                          .ShowDefault();
  app.AddFlag("--no-steering", options.no_steering,
              "viewers may not steer a replay at this gateway; 'palpate-replay --locked' forbids "
              "it at all of them");
  app.Add("--allow-origin", options.origins,
          "origin of another web page that may attach and take a tool, as "
          "https://app.example.org; *: every page.  This gateway's own page, and programs "
          "that are no web page, always may.  Desktop applications that call themselves "
          "file:// may look, and take tools if file:// is given here");
  AddHostNameOption(app, "the page", options.host_names);
  std::vector<std::string> proxies;
  app.Add("--proxy", proxies,
          "address of a reverse proxy.  Its X-Forwarded-For is believed, so that limits "
          "hold for each visitor and not for the proxy");
  app.Add("--tokens", options.tokens,
          "file of access tokens: all but the page's own files then needs a token.  SIGHUP "
          "(systemctl reload palpate-viewer) reads it again.  Connections end at once whose "
          "token is gone or has another role; a file with a mistake changes nothing");
  const Option course =
      app.Add("--course", options.course,
              "folder of a course: its people have tokens, too, which a teacher makes on the page. "
              "Made where it is not there; the first start prints a teacher's link, once")
          .TypeName("FOLDER");
  std::vector<std::string> make_token;
  const Option make =
      app.Add("--make-token", make_token,
              "ROLE NAME: print a new token (watch, drive or operate) of this name, add it to the "
              "--tokens file or the --course, and end")
          .Words(2);
  app.Add(
         "--export-csv", options.export_csv,
         "write every trial of the --course as CSV, a line each, and end; '-': to the terminal.  A "
         "gateway may be using the course")
      .TypeName("FILE");
  app.Add("--tls-cert", options.tls_cert,
          "certificate chain of this host (PEM), as 'palpate-identities certificate' makes "
          "it; the port then speaks HTTPS and wss, TLS 1.2 or newer");
  app.Add("--tls-key", options.tls_key,
          "its private key (PEM), which nobody but its owner may read");
  app.Add("--transport", options.transport,
          "how poses and wrenches of the mice travel: auto, shm or udp")
      .ShowDefault();
  AddServerOptions(app, options);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (make.given()) {
    options.make_token = ToNewToken(make_token, options.tokens + options.course);
    if (!options.tokens.empty() && !options.course.empty()) {
      throw UsageError("--make-token: give --tokens or --course, where it is to be entered");
    }
    return options;
  }
  if (!options.export_csv.empty()) {
    if (!course.given()) throw UsageError("--export-csv: --course FOLDER says of which course");
    return options;
  }
  // One for each seat.
  if (course.given() && !mice.given()) options.max_mice = kMostMice;
  if (!port.given()) {
    throw UsageError("--http is missing: the port of page and WebSocket, as --http 8765");
  }
  if (options.tls_cert.empty() != options.tls_key.empty()) {
    throw UsageError("--tls-cert and --tls-key belong together: a certificate and its key");
  }
  for (const std::string& proxy : proxies) options.proxies.push_back(ToAddress("--proxy", proxy));
  if (page.given() && !std::filesystem::is_directory(options.page)) {
    throw UsageError("--page " + options.page +
                     ": there is no such folder; give the one that the target 'page' builds "
                     "(build/page), or leave it out");
  }
  ToAddress("--bind", options.address);
  dds::ParseTransport(options.transport);  // throws
  return options;
}

}  // namespace palpate
