#pragma once

#include <string>

#include <gtest/gtest.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace palpate::test {

/// A key and a self-signed certificate for 127.0.0.1.
class TestCertificate {
 public:
  TestCertificate() {
    Program openssl("/usr/bin/openssl", {"req", "-x509", "-newkey", "ec", "-pkeyopt",
                                         "ec_paramgen_curve:P-256", "-nodes", "-days", "1", "-subj",
                                         "/CN=127.0.0.1", "-keyout", key(), "-out", file()});
    EXPECT_EQ(openssl.Exit(), 0) << openssl.Output();
  }
  std::string file() const { return folder_ / "cert.pem"; }
  std::string key() const { return folder_ / "key.pem"; }

 private:
  const Folder folder_;
};

}  // namespace palpate::test
