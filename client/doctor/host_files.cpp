#include "client/doctor/host_files.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include <string.h>
#include <unistd.h>

#include "common/files/whole_file.h"

namespace palpate::doctor {
namespace {

/// The kernel's files about itself and about a process have some kB, a mount table more.
constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 20;

}  // namespace

namespace fs = std::filesystem;

bool HostFiles::Has(const std::string& path) const {
  std::error_code ignored;
  return fs::exists(At(path), ignored);
}

bool HostFiles::MayOpen(const std::string& path) const {
  return may_open ? may_open(path) : access(At(path).c_str(), R_OK | W_OK) == 0;
}

std::optional<std::string> HostFiles::Read(const std::string& path) const {
  std::optional<std::string> text = TryReadWholeFile(At(path), kMostBytes);
  if (!text) return std::nullopt;
  const std::size_t last = text->find_last_not_of(" \t\n");
  text->resize(last == std::string::npos ? 0 : last + 1);
  return text;
}

std::optional<long long> HostFiles::ReadNumber(const std::string& path) const {
  const std::optional<std::string> text = Read(path);
  if (!text) return std::nullopt;
  char* end = nullptr;
  const long long number = std::strtoll(text->c_str(), &end, 10);
  if (end == text->c_str()) return std::nullopt;
  return number;
}

std::vector<std::string> HostFiles::Names(const std::string& folder,
                                          const std::string& begin) const {
  std::vector<std::string> names;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(At(folder), unreadable)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(begin)) names.push_back(name);
  }
  std::ranges::sort(names, [](const std::string& a, const std::string& b) {
    return strverscmp(a.c_str(), b.c_str()) < 0;
  });
  return names;
}

}  // namespace palpate::doctor
