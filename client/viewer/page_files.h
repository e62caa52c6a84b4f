#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

/// The path of a request's target: without its query, %xx resolved, beginning with '/'.  Nothing
/// where it is none: a bad %xx, a zero, a backslash, or a '..' as one of its names.
std::optional<std::string> PathOfTarget(std::string_view target);

/// By its name's ending.
std::string ContentTypeOf(const std::filesystem::path& path);

/// True where an Accept-Encoding header allows gzip.
bool AcceptsGzip(std::string_view accept_encoding);

/// A file of the page.
struct PageFile {
  std::filesystem::path path;
  std::string content_type;
  bool gzip = false;    ///< the file is FILE.gz, for a client that asked for FILE
  bool hashed = false;  ///< its name changes with its content: to be kept for ever
};

/// The web page's static files, below one folder: nothing outside it is ever given, by no path and
/// by no symbolic link.
class PageFiles {
 public:
  explicit PageFiles(const std::filesystem::path& folder);

  /// The page is built: its folder has an index.html.
  bool built() const;
  /// @param path  of PathOfTarget.  A folder's index.html stands for it.
  std::optional<PageFile> Find(const std::string& path, bool gzip) const;
  /// What it holds, once for all who are sent it at the same time.  Null: it cannot be read.
  std::shared_ptr<const std::string> Read(const PageFile& file);

 private:
  std::filesystem::path folder_;
  std::map<std::filesystem::path, std::weak_ptr<const std::string>> read_;
};

/// What stands in for a page that is not built: how to build it.
std::string PageIsNotBuilt(const std::filesystem::path& folder);

}  // namespace palpate
