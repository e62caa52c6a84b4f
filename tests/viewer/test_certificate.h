#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/program.h"

namespace palpate::test {

/// A key and a certificate for 127.0.0.1 that it has signed itself, in files of a folder of their
/// own, until this object goes.
class TestCertificate {
 public:
  TestCertificate() {
    std::filesystem::create_directories(folder_);
    Program openssl("/usr/bin/openssl", {"req", "-x509", "-newkey", "ec", "-pkeyopt",
                                         "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj",
                                         "/CN=127.0.0.1", "-keyout", key(), "-out", certificate()});
    EXPECT_EQ(openssl.Exit(), 0) << openssl.Output();
  }
  ~TestCertificate() { std::filesystem::remove_all(folder_); }
  TestCertificate(const TestCertificate&) = delete;
  TestCertificate& operator=(const TestCertificate&) = delete;

  std::string certificate() const { return folder_ + "/cert.pem"; }
  std::string key() const { return folder_ + "/key.pem"; }

 private:
  const std::string folder_ =
      testing::TempDir() + "palpate_certificate_" + std::to_string(getpid());
};

}  // namespace palpate::test
