#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/participant.h"
#include "common/program/command_line.h"

namespace palpate {

/// The address of a gateway.
struct ViewerUrl {
  std::string host = "127.0.0.1";
  int port = 8765;
  std::string text() const { return "ws://" + host + ":" + std::to_string(port); }
};
/// Parses "ws://HOST:PORT", with or without a final slash.  Throws UsageError.
ViewerUrl ParseViewerUrl(const std::string& url);

struct LoadRunOptions : ServerOptions {
  std::vector<std::size_t> stations{
      1};  ///< several: one run for each combination with an entry of `viewers`
  std::vector<std::size_t> viewers{0};
  double seconds = 10.0;  ///< of each run, after its warm-up
  ViewerUrl viewer_url;
  double rate_hz = 30.0;  ///< rate of the gateway's tool states
  std::string scene;      ///< name or file; empty: all that the server serves
  std::string script;     ///< file; empty: the scene's own
  std::string name = "load";
  dds::Transport transport = dds::Transport::kAuto;
  std::string realtime = "prefer";
  double patience_s = 10.0;
  std::string json;        ///< file or "-"; empty: none
  std::size_t copies = 0;  ///< if not 0: writes `copies_file` and exits
  std::string copies_file;
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<LoadRunOptions> ParseLoadOptions(int argc, const char* const* argv);

}  // namespace palpate
