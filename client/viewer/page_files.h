#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

/// Returns the path of a request's target: without query, %xx decoded, beginning with '/'.  Returns
/// nothing if it has a bad %xx, a zero, a backslash or a ".." component.
std::optional<std::string> PathOfTarget(std::string_view target);

/// Derived from the file name's extension.
std::string ContentTypeOf(const std::filesystem::path& path);

/// Returns whether an Accept-Encoding header allows gzip.
bool AcceptsGzip(std::string_view accept_encoding);

/// A file of the page.
struct PageFile {
  std::filesystem::path path;
  std::string content_type;
  bool gzip = false;    ///< the file is FILE.gz, for a client that asked for FILE
  std::string below;    ///< folder that no link may lead out of (OpenFileBelow); empty: any may
  bool hashed = false;  ///< its name changes with its content, so it may be cached for ever
};

/// The web page's static files below one folder.  Nothing outside that folder is served, neither
/// through a path nor through a symbolic link.
class PageFiles {
 public:
  explicit PageFiles(const std::filesystem::path& folder);

  /// Returns whether the page is built: its folder has an index.html.
  bool built() const;
  /// @param path  from PathOfTarget.  For a folder, its index.html is found.
  std::optional<PageFile> Find(const std::string& path, bool gzip) const;
  /// Returns the file's content, shared by all clients that are sent it at the same time.  Null: it
  /// cannot be read.
  std::shared_ptr<const std::string> Read(const PageFile& file);

 private:
  std::filesystem::path folder_;
  std::map<std::filesystem::path, std::weak_ptr<const std::string>> read_;
};

/// Returns a page, shown if the real one is not built, that says how to build it.
std::string PageIsNotBuilt(const std::filesystem::path& folder);

}  // namespace palpate
