#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace palpate::doctor {

/// A host as described by its files: /proc, /sys, /dev and /tmp below `root`, which is "" for this
/// host and a folder for a host simulated by a test.
struct HostFiles {
  std::string root{};
  /// Returns whether this user may read and write a file.  Default: access(2), which always
  /// succeeds for root.
  std::function<bool(const std::string& path)> may_open{};

  std::string At(const std::string& path) const { return root + path; }
  bool Has(const std::string& path) const;
  bool MayOpen(const std::string& path) const;
  /// Returns the file's text without trailing white space; nothing if it cannot be read.
  std::optional<std::string> Read(const std::string& path) const;
  /// Returns the first integer in a file.
  std::optional<long long> ReadNumber(const std::string& path) const;
  /// Returns the names in a folder that start with `begin`, in natural order ("cpu2" before
  /// "cpu10"); empty if there is no such folder.
  std::vector<std::string> Names(const std::string& folder, const std::string& begin = "") const;
};

}  // namespace palpate::doctor
