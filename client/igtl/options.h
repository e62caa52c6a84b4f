#pragma once

#include <optional>
#include <string>

#include "common/dds/network.h"

namespace palpate {

struct IgtlOptions {
  int domain = 0;
  dds::Network network;
  std::string address = "127.0.0.1";
  int port = 18944;
  double rate_Hz = 60.0;
  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<IgtlOptions> ParseOptions(int argc, const char* const* argv);

}  // namespace palpate
