#include "client/viewer/web_stream.h"

#include <string>

#include <boost/asio/ssl/context.hpp>
#include <gtest/gtest.h>
#include <openssl/ssl.h>

#include "tests/viewer/test_certificate.h"

namespace palpate::test {
namespace {

TEST(WebStream, OffersNoSuiteThatEncryptsAndAuthenticatesApart) {
  const TestCertificate certificate;
  boost::asio::ssl::context context = MakeTls(certificate.file(), certificate.key());
  const STACK_OF(SSL_CIPHER)* const suites = SSL_CTX_get_ciphers(context.native_handle());
  int of_tls_1_2 = 0;
  for (int i = 0; i < sk_SSL_CIPHER_num(suites); ++i) {
    const SSL_CIPHER* const suite = sk_SSL_CIPHER_value(suites, i);
    EXPECT_EQ(SSL_CIPHER_is_aead(suite), 1) << SSL_CIPHER_get_name(suite);
    const std::string version = SSL_CIPHER_get_version(suite);
    EXPECT_TRUE(version == "TLSv1.2" || version == "TLSv1.3") << SSL_CIPHER_get_name(suite);
    of_tls_1_2 += version == "TLSv1.2";
  }
  EXPECT_GT(of_tls_1_2, 0);
}

}  // namespace
}  // namespace palpate::test
