#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace palpate::doctor {

/// A host as its files show it: /proc, /sys, /dev, /tmp below `root`, which is "" for this host and
/// a folder for a host that a test has made up.
struct HostFiles {
  std::string root{};
  /// Whether this user may read and write a file.  By default access(2), to which root is no test.
  std::function<bool(const std::string& path)> may_open{};

  std::string At(const std::string& path) const { return root + path; }
  bool Has(const std::string& path) const;
  bool MayOpen(const std::string& path) const;
  /// The file's text without white space at its end; nothing where it cannot be read.
  std::optional<std::string> Read(const std::string& path) const;
  /// The first integer in a file.
  std::optional<long long> ReadNumber(const std::string& path) const;
  /// Names in a folder that begin so, sorted as people count ("cpu2" before "cpu10"); none where
  /// there is no such folder.
  std::vector<std::string> Names(const std::string& folder, const std::string& begin = "") const;
};

}  // namespace palpate::doctor
