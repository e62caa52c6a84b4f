#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gmock/gmock.h>

#include "client/doctor/checks.h"
#include "tests/support/folder.h"

namespace palpate::doctor {

/// A made-up host: a folder with the files that a check reads.
class MadeUpHost {
 public:
  explicit MadeUpHost(const std::map<std::string, std::string>& texts = {}) {
    files.root = folder_.path();
    for (const auto& [path, text] : texts) Write(path, text);
  }

  void Write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(files.At(path)).parent_path());
    std::ofstream(files.At(path), std::ios::binary) << text;
  }

  HostFiles files;

 private:
  const test::Folder folder_;
};

inline void PrintTo(const Finding& finding, std::ostream* out) {
  *out << static_cast<int>(finding.status) << ": " << finding.found << " -> " << finding.remedy;
}

/// Matches a finding with these words, which has a remedy exactly if it is not ok.
inline testing::Matcher<Finding> Is(Status status, const std::string& found = "",
                                    const std::string& remedy = "") {
  using testing::Field, testing::HasSubstr;
  return testing::AllOf(
      Field(&Finding::status, status), Field(&Finding::found, HasSubstr(found)),
      Field(&Finding::remedy, HasSubstr(remedy)),
      Field(&Finding::remedy,
            testing::ResultOf([](const std::string& text) { return text.empty(); },
                              status == Status::kOk)));
}
inline auto IsOk(const std::string& found = "") {
  return Is(Status::kOk, found);
}
inline auto IsWarning(const std::string& found = "", const std::string& remedy = "") {
  return Is(Status::kWarning, found, remedy);
}
inline auto IsFault(const std::string& found = "", const std::string& remedy = "") {
  return Is(Status::kFault, found, remedy);
}

}  // namespace palpate::doctor
