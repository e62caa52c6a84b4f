#pragma once

#include <string>

namespace palpate::test {

/// A key and a certificate for 127.0.0.1 that it has signed itself, in files of a folder of their
/// own, until this object goes.
class TestCertificate {
 public:
  TestCertificate();
  ~TestCertificate();
  TestCertificate(const TestCertificate&) = delete;
  TestCertificate& operator=(const TestCertificate&) = delete;

  std::string certificate() const { return folder_ + "/cert.pem"; }
  std::string key() const { return folder_ + "/key.pem"; }

 private:
  std::string folder_;
};

}  // namespace palpate::test
