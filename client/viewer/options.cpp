#include "client/viewer/options.h"

#include <filesystem>

#include "common/dds/participant.h"
#include "common/error.h"
#include "common/files/project_files.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Shows the scenes of a palpate-server in web browsers.  It serves the web page,
and on the same port a WebSocket with the Foxglove protocol (messages: cdr,
schemas: omgidl).  Prints a line that begins with 'ready' and has the page's
address.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-viewer --http 8765
      the page at http://127.0.0.1:8765/, for this host only; the desktop
      applications of Foxglove and Lichtblick connect to ws://127.0.0.1:8765/ to
      watch
  palpate-viewer --http 8765 --allow-origin https://app.foxglove.dev
      lets Foxglove's web application connect, too
  palpate-viewer --http 8765 --bind 0.0.0.0 --max-mice 0 --no-steering
      for a class on the same network: everybody may watch, nobody may take a
      tool with the mouse or steer a replay; a second gateway, open to the
      teacher's host only, may allow both
  palpate-viewer --make-token operate teacher --tokens tokens.txt
  palpate-viewer --http 8765 --bind 0.0.0.0 --tokens tokens.txt \
                 --tls-cert lab.pem --tls-key lab.key --host-name lab.example
      the first command prints a teacher's token; the page at
      https://lab.example:8765/#token=TOKEN then needs a token.  Its role
      'watch' allows watching; 'drive' also taking tools and steering replays;
      'operate' also deciding about stations
  palpate-viewer --http 8765 --course anatomy
      a class: the first start prints a link for the teacher, who adds people
      and makes their links on the page
  palpate-viewer --course anatomy --export-csv anatomy.csv
      all trials of the course so far, for a spreadsheet
  palpate-viewer --http 8765 --network eth0
      shows a server on another host, also started with --network

Each viewer has its own queue, which keeps only the newest messages: a viewer
that stalls loses frames and does not delay others.  GET /healthz reports the
state, GET /scene/NAME.bundle returns a scene.  When all places are taken, a new
viewer replaces one of the address that holds the most places, if its own
address holds fewer.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

/// As many as a server has stations.
constexpr int kMostMice = 32;

boost::asio::ip::address ToAddress(const char* flag, const std::string& text) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(text, error);
  if (error) {
    throw UsageError(std::string(flag) + " '" + text +
                     "' is not an IP address; give one such as 127.0.0.1 or 0.0.0.0");
  }
  return address;
}

ViewerOptions::NewToken ToNewToken(const std::vector<std::string>& words, const std::string& file) {
  const auto role = ParseRole(words.at(0));
  if (!role) {
    throw UsageError("--make-token " + words[0] +
                     ": is not a role; give watch, drive or operate, then a name");
  }
  if (file.empty()) {
    throw UsageError(
        "--make-token: the token must be stored; give --tokens FILE or --course FOLDER");
  }
  return {*role, words.at(1)};
}

}  // namespace

std::optional<ViewerOptions> ParseViewerOptions(int argc, const char* const* argv) {
  ViewerOptions options;
  options.page = PlaceOf(ProjectFile::kPage);
  const CommandLine app(kAbout, "palpate-viewer", kExamples);
  const Option port =
      app.Add("--http", options.port, "port of the page and its WebSocket; 0: any free port")
          .Range(0, 65535);
  app.Add("--bind", options.address, "address to listen on; 0.0.0.0: all networks of this host")
      .ShowDefault();
  const Option page =
      app.Add("--page", options.page,
              "folder of the built page; default: that of this program's package or build");
  app.Add("--rate", options.rate_hz, "updates of each tool per second, for each viewer")
      .Range(10.0, 60.0)
      .ShowDefault();
  app.Add("--max-viewers", options.max_viewers,
          "maximum number of viewers; further ones are refused")
      .Range(1, 10000)
      .ShowDefault();
  const Option mice =
      app.Add("--max-mice", options.max_mice,
              "maximum number of tools held with the mouse at the same time; 0: none.  "
              "Default with --course: 32")
          .Range(0, kMostMice)
          .ShowDefault();
  app.AddFlag(
      "--no-steering", options.no_steering,
      "viewers of this gateway may not steer a replay; 'palpate-replay --locked' forbids it "
      "for all gateways");
  app.Add("--allow-origin", options.origins,
          "origin of another web page that may connect and take tools, such as "
          "https://app.example.org; *: any page.  This gateway's page, and programs other than "
          "browsers, always may.  Desktop applications with the origin file:// may watch; give "
          "file:// to let them take tools");
  AddHostNameOption(app, "the page", options.host_names);
  std::vector<std::string> proxies;
  app.Add("--proxy", proxies,
          "address of a reverse proxy, whose X-Forwarded-For header is trusted, so that limits "
          "apply to each visitor and not to the proxy");
  app.Add("--tokens", options.tokens,
          "file of access tokens.  With it, everything but the page's own files needs a token.  "
          "SIGHUP (systemctl reload palpate-viewer) reads it again and closes connections whose "
          "token was removed or has another role; a file with a mistake is ignored");
  const Option course =
      app.Add("--course", options.course,
              "folder of a course, created if it does not exist.  Its people have tokens, which a "
              "teacher makes on the page; the first start prints the teacher's link, once")
          .TypeName("FOLDER");
  std::vector<std::string> make_token;
  const Option make =
      app.Add("--make-token", make_token,
              "ROLE NAME: add a token for this role (watch, drive or operate) and name to --tokens "
              "or --course, print it, and exit")
          .Words(2);
  app.Add("--export-csv", options.export_csv,
          "write all trials of the --course to this CSV file, one per line, and exit; -: standard "
          "output.  A gateway may use the course meanwhile")
      .TypeName("FILE");
  app.Add("--tls-cert", options.tls_cert,
          "certificate chain of this host (PEM), such as 'palpate-identities certificate' makes; "
          "the port then serves https and wss (TLS 1.2 or newer)");
  app.Add("--tls-key", options.tls_key,
          "private key of --tls-cert (PEM); only its owner may have access to the file");
  app.Add("--transport", options.transport,
          "transport of the mice's poses and wrenches: auto, shm or udp")
      .ShowDefault();
  AddServerOptions(app, options);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (make.given()) {
    options.make_token = ToNewToken(make_token, options.tokens + options.course);
    if (!options.tokens.empty() && !options.course.empty()) {
      throw UsageError("--make-token: give either --tokens or --course, not both");
    }
    return options;
  }
  if (!options.export_csv.empty()) {
    if (!course.given()) throw UsageError("--export-csv needs a course; add --course FOLDER");
    return options;
  }
  // One for each seat.
  if (course.given() && !mice.given()) options.max_mice = kMostMice;
  if (!port.given()) {
    throw UsageError("--http is missing; give the port of the page, as in --http 8765");
  }
  if (options.tls_cert.empty() != options.tls_key.empty()) {
    throw UsageError("--tls-cert and --tls-key belong together; give both or neither");
  }
  for (const std::string& proxy : proxies) options.proxies.push_back(ToAddress("--proxy", proxy));
  if (page.given() && !std::filesystem::is_directory(options.page)) {
    throw UsageError("--page " + options.page +
                     ": is not a folder; give the one that the target 'page' builds (build/page), "
                     "or omit the option");
  }
  ToAddress("--bind", options.address);
  dds::ParseTransport(options.transport);  // throws
  return options;
}

}  // namespace palpate
