#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/ip/address.hpp>

#include "client/viewer/tokens.h"
#include "common/program/command_line.h"

namespace palpate {

struct ViewerOptions : ServerOptions {
  int port = 0;  ///< 0: any free port
  std::string address = "127.0.0.1";
  std::string page;  ///< folder
  double rate_hz = 30.0;
  std::size_t max_viewers = 300;
  int max_mice = 4;
  bool no_steering = false;                       ///< nobody may steer a replay here
  std::vector<std::string> origins;               ///< of other pages that may attach; "*": any
  std::vector<std::string> host_names;            ///< of this host, in lower case
  std::vector<boost::asio::ip::address> proxies;  ///< proxies whose X-Forwarded-For is believed
  std::string tokens;                             ///< file; empty: no tokens are required
  std::string course;                             ///< folder; empty: none
  std::string tls_cert;                           ///< file; empty: in the clear
  std::string tls_key;
  /// Prefix of the names of mouse stations: a gateway with an identity may write poses only under
  /// this one.
  std::string mouse_prefix() const { return network.secured() ? "mouse_" : ""; }
  bool asks_for_tokens() const { return !tokens.empty() || !course.empty(); }
  /// If set, makes a token instead of serving.
  struct NewToken {
    Access role = Access::kNone;
    std::string name;
  };
  std::optional<NewToken> make_token;
  std::string export_csv;          ///< file to write instead of serving; "-": stdout
  std::string transport = "auto";  ///< of the mouse stations
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<ViewerOptions> ParseViewerOptions(int argc, const char* const* argv);

}  // namespace palpate
