#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/course/history.h"
#include "client/viewer/http_session.h"
#include "client/viewer/hub.h"
#include "client/viewer/options.h"
#include "client/viewer/tokens.h"
#include "client/viewer/viewer_limits.h"
#include "client/viewer/visitor.h"
#include "client/viewer/web_stream.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/http/lobby.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

namespace net = boost::asio;
using net::ip::tcp;

constexpr std::chrono::microseconds kTick{8333};
/// Connections in addition to the viewers': browsers open some for the page's files.
constexpr std::size_t kHttpConnections = 200;

class Listener {
 public:
  /// @param tls  null: in the clear.
  Listener(net::io_context& io, Hub& hub, net::ssl::context* tls)
      : acceptor_(io),
        retry_(io),
        service_{hub, PageFiles(hub.options().page), ScenePacker(io), tls,
                 std::make_shared<Lobby>(kHttpConnections, kHttpConnections / 2)} {
    const ViewerOptions& options = hub.options();
    const tcp::endpoint at(net::ip::make_address(options.address),
                           static_cast<unsigned short>(options.port));
    boost::system::error_code error;
    acceptor_.open(at.protocol(), error);
    if (!error) acceptor_.set_option(net::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
    if (error) {
      throw Error("cannot listen at " + options.address + " port " + std::to_string(options.port) +
                  " (" + error.message() + "); give another --http or --bind");
    }
    Accept();
  }

  tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }
  void Stop() {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    retry_.cancel();
  }

 private:
  void Accept() {
    acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (error == net::error::operation_aborted || !acceptor_.is_open()) return;
      if (error) {
        // For instance, no descriptor is free: other connections will close.
        spdlog::warn("a connection could not be taken: {}", error.message());
        retry_.expires_after(std::chrono::milliseconds(100));
        retry_.async_wait([this](boost::system::error_code stopped) {
          if (!stopped) Accept();
        });
        return;
      }
      std::make_shared<HttpSession>(std::move(socket), service_)->Begin();
      Accept();
    });
  }

  tcp::acceptor acceptor_;
  net::steady_timer retry_;
  HttpService service_;
};

/// Returns the addresses of the page: host names first, since certificates are issued for them.
std::string Urls(const ViewerOptions& options, const tcp::endpoint& endpoint) {
  const std::string scheme = options.tls_cert.empty() ? "http://" : "https://";
  const net::ip::address address = endpoint.address();
  std::ostringstream urls;
  for (const std::string& name : options.host_names) {
    urls << scheme << name << ':' << endpoint.port() << "/ ";
  }
  for (const net::ip::address& host :
       address.is_unspecified() ? HostAddresses(address.is_v6()) : std::vector{address}) {
    urls << scheme << tcp::endpoint(host, endpoint.port()) << "/ ";
  }
  std::string all = urls.str();
  all.pop_back();
  return all;
}

/// Warns what it means that other hosts can reach this gateway.
void WarnOfNetwork(const ViewerOptions& options) {
  if (options.tls_cert.empty()) {
    spdlog::warn(
        "traffic at {} is not encrypted: others in the network can read it{}; --tls-cert and "
        "--tls-key encrypt it",
        options.address, options.asks_for_tokens() ? ", and use the tokens in it" : "");
  }
  if (!options.asks_for_tokens()) {
    spdlog::warn(
        "every host that can reach {} can watch{}{}; --tokens restricts access, --bind 127.0.0.1 "
        "limits it to this host",
        options.address,
        options.no_steering ? ""
                            : ", steer a replay that is not --locked (--no-steering forbids it)",
        options.max_mice > 0 ? ", and take a tool with the mouse (--max-mice 0 forbids it)" : "");
  }
}

void Announce(const ViewerOptions& options, Hub& hub, const tcp::endpoint& endpoint) {
  if (!endpoint.address().is_loopback()) WarnOfNetwork(options);
  if (!PageFiles(options.page).built()) {
    spdlog::warn(
        "the page is not built (looked for it in {}); a page that says so is served instead",
        options.page);
  }
  const std::string urls = Urls(options, endpoint);
  if (hub.course() != nullptr) hub.course()->trials().lock().Tell(urls);
  if (const auto teacher = hub.rights().MakeFirstTeacher()) {
    std::printf("the teacher's link, shown only now: %s#token=%s\n",
                urls.substr(0, urls.find(' ')).c_str(), teacher->token.c_str());
  }
  std::printf("ready: page %s; domain %d; up to %zu viewers, %d with a mouse\n", urls.c_str(),
              options.domain, options.max_viewers, options.max_mice);
  std::fflush(stdout);
}

bool HasTerminal() {
  const int terminal = open("/dev/tty", O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal >= 0) close(terminal);
  return terminal >= 0;
}

/// Handles SIGHUP, the request to read files again.  SIGHUP also comes when a terminal closes; it
/// then ends a gateway that was started there, unless by `nohup`.
class ReloadSignal {
 public:
  ReloadSignal(net::io_context& io, std::function<void()> reload)
      : signals_(io, SIGHUP), reload_(std::move(reload)) {
    Wait();
  }
  void Stop() {
    boost::system::error_code ignored;
    signals_.cancel(ignored);
  }

 private:
  void Wait() {
    signals_.async_wait([this](boost::system::error_code stopped, int) {
      if (stopped) return;
      if (ends_with_terminal_ && !HasTerminal()) {
        std::raise(SIGTERM);
      } else {
        reload_();
      }
      Wait();
    });
  }

  static bool IsIgnored() {
    struct sigaction now {};
    return sigaction(SIGHUP, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
  }

  const bool ends_with_terminal_ = HasTerminal() && !IsIgnored();  // asked before signals_ is made
  net::signal_set signals_;
  const std::function<void()> reload_;
};

/// Serves until a signal arrives.  One thread does everything: HTTP, WebSockets and, 120 times
/// a second, the DDS readers.  Each message was serialised once, by its writer, and is shared
/// by all viewers.
/// Throws Error.
void Serve(const ViewerOptions& options) {
  StopSignal stop;
  std::signal(SIGPIPE, SIG_IGN);  // the input pipe of a station may be closed
  // Must outlive the handlers, which the io_context holds until its end.
  std::optional<net::ssl::context> tls;
  if (!options.tls_cert.empty()) tls = MakeTls(options.tls_cert, options.tls_key);
  net::io_context io(1);
  Hub hub(io, options);
  ReloadSignal reload(io, [&hub] { hub.ReadTokensAnew(); });
  Listener listener(io, hub, tls ? &*tls : nullptr);
  Announce(options, hub, listener.endpoint());

  net::steady_timer timer(io, kTick);
  std::int64_t ending_ns = 0;
  std::function<void(boost::system::error_code)> tick = [&](boost::system::error_code) {
    const std::int64_t now_ns = SteadyNanoseconds();
    if (stop.stopped() && ending_ns == 0) {
      ending_ns = now_ns;
      listener.Stop();
      reload.Stop();
      hub.BeginToEnd(now_ns);
    }
    const bool goes_on = hub.Tick(now_ns);
    if (ending_ns != 0 && (!goes_on || now_ns - ending_ns > ViewerLimits::kFarewell_ns))
      return io.stop();
    // By the absolute clock, but without a burst after a delay.
    timer.expires_at(std::max(timer.expiry() + kTick, std::chrono::steady_clock::now()));
    timer.async_wait(tick);
  };
  timer.async_wait(tick);
  io.run();
}

/// Writes a course's history as CSV, for use in a terminal.  Throws Error.
void ExportCsv(const ViewerOptions& options) {
  if (!std::filesystem::exists(std::filesystem::path(options.course) / "course.sqlite")) {
    throw Error("--course " + options.course + ": is not a course; give the folder of one");
  }
  CourseFile file(options.course);
  WriteOutput("--export-csv", options.export_csv,
              History({}, RosterTable(file).All(), TrialTable(file).Ended()).Csv());
}

int RunGateway(const ViewerOptions& options) {
  if (!options.export_csv.empty()) {
    ExportCsv(options);
    return 0;
  }
  if (options.make_token) {
    const auto& [role, name] = *options.make_token;
    if (options.course.empty()) {
      std::printf("%s\n", MakeToken(options.tokens, role, name).c_str());
    } else {
      CourseFile file(options.course);
      std::printf("%s\n", Roster(file).Make({name}, role).front().token.c_str());
    }
    spdlog::info(
        "'{}' may {}; the token is shown only now, so keep it.  The page is opened with "
        "#token=TOKEN at the end of its address; gateways that run read {} anew at "
        "SIGHUP (systemctl reload palpate-viewer)",
        name, RoleName(role), options.tokens + options.course);
  } else {
    Serve(options);
  }
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-viewer", argc, argv, palpate::ParseViewerOptions,
                             palpate::RunGateway);
}
