#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// A host of the test's own: a folder with the files that a check reads.
class MadeUpHost {
 public:
  MadeUpHost() {
    std::string pattern = testing::TempDir() + "doctor-XXXXXX";
    files.root = mkdtemp(pattern.data());
  }
  ~MadeUpHost() { std::filesystem::remove_all(files.root); }
  MadeUpHost(const MadeUpHost&) = delete;
  MadeUpHost& operator=(const MadeUpHost&) = delete;

  void Write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(files.At(path)).parent_path());
    std::ofstream(files.At(path), std::ios::binary) << text;
  }

  HostFiles files;
};

}  // namespace palpate::doctor
