#include "client/viewer/page_files.h"

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/text/number_of.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLargestFile = std::uint64_t{64} << 20;  // the page has 2 MB

/// The types of the files that Vite generates, and of exercises' pictures.
constexpr std::array<std::pair<std::string_view, const char*>, 7> kContentTypes = {{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".svg", "image/svg+xml"},
    {".webp", "image/webp"},
}};

bool IsBelow(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

}  // namespace

std::string ContentTypeOf(const fs::path& path) {
  for (const auto& [extension, type] : kContentTypes) {
    if (path.extension() == extension) return type;
  }
  return "application/octet-stream";
}

std::optional<std::string> PathOfTarget(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  if (!target.starts_with('/')) return std::nullopt;
  std::string path;
  for (std::size_t i = 0; i < target.size(); ++i) {
    char c = target[i];
    if (c == '%') {
      if (i + 2 >= target.size()) return std::nullopt;
      const auto value = NumberOf<unsigned>(target.substr(i + 1, 2), 16);
      if (!value) return std::nullopt;
      c = static_cast<char>(*value);
      i += 2;
    }
    if (c == '\0' || c == '\\') return std::nullopt;
    path += c;
  }
  const fs::path names(path);
  if (std::ranges::find(names, fs::path("..")) != names.end()) return std::nullopt;
  return path;
}

bool AcceptsGzip(std::string_view header) {
  const std::size_t at = header.find("gzip");
  if (at == std::string_view::npos) return false;
  std::string_view rest = header.substr(at + 4);
  rest = rest.substr(0, rest.find(','));
  // "gzip;q=0" refuses it, with any number of decimals.
  const std::size_t q = rest.find("q=");
  return q == std::string_view::npos ||
         rest.substr(q + 2).find_first_of("123456789") != std::string_view::npos;
}

PageFiles::PageFiles(const fs::path& folder) {
  std::error_code error;
  folder_ = fs::weakly_canonical(folder, error);
  if (error) folder_ = folder;
}

bool PageFiles::built() const {
  return Find("/index.html", false).has_value();
}

std::optional<PageFile> PageFiles::Find(const std::string& path, bool gzip) const {
  const auto regular_below = [&](const fs::path& wanted) -> std::optional<fs::path> {
    std::error_code error;
    const fs::path real = fs::canonical(wanted, error);
    if (error || !IsBelow(real, folder_) || !fs::is_regular_file(real, error)) return std::nullopt;
    return real;
  };
  fs::path wanted = folder_ / fs::path(path).relative_path();
  if (path.ends_with('/')) wanted /= "index.html";
  PageFile file;
  file.content_type = ContentTypeOf(wanted);
  file.hashed = path.starts_with("/assets/");  // named so by Vite
  if (gzip) {
    fs::path packed = wanted;
    packed += ".gz";
    if (const auto real = regular_below(packed)) {
      file.path = *real;
      file.gzip = true;
      return file;
    }
  }
  const auto real = regular_below(wanted);
  if (!real) return std::nullopt;
  file.path = *real;
  return file;
}

std::shared_ptr<const std::string> PageFiles::Read(const PageFile& file) {
  std::weak_ptr<const std::string>& read = read_[file.path];
  if (auto shared = read.lock()) return shared;
  std::optional<std::string> content;
  try {
    content = file.below.empty() ? ReadWholeFile(file.path, kLargestFile)
                                 : ReadFileBelow(file.below, file.path, kLargestFile);
  } catch (const Error&) {
    return nullptr;
  }
  const auto shared = std::make_shared<const std::string>(std::move(*content));
  read = shared;
  return shared;
}

std::string PageIsNotBuilt(const fs::path& folder) {
  return "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width\">"
         "<meta name=\"color-scheme\" content=\"light dark\"><title>Palpate</title>"
         "<body style=\"font: 1.1rem system-ui, sans-serif; max-width: 40rem; margin: 3rem auto; "
         "padding: 0 1rem\"><h1>The page is not built</h1>"
         "<p>The gateway runs, and its WebSocket answers at this address: Foxglove and Lichtblick "
         "can attach. The page itself was looked for in</p><pre>" +
         folder.string() +
         "</pre><p>Build it from the repository's root, and load this page again:</p>"
         "<pre>deploy/setup\ncmake --build --preset release --target page</pre>"
         "<p>or name the folder of a built one with <code>palpate-viewer --page FOLDER</code>.</p>"
         "</body></html>\n";
}

}  // namespace palpate
