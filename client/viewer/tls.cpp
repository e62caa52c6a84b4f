#include "client/viewer/tls.h"

#include <boost/asio/buffer.hpp>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/ssl.h>

#include "common/error.h"
#include "common/files/private_file.h"
#include "common/files/whole_file.h"

namespace palpate {
namespace {

/// Of a chain of certificates, or a key: some kB each, with remarks before them.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;

}  // namespace

boost::asio::ssl::context MakeTls(const std::string& certificate, const std::string& key) {
  namespace ssl = boost::asio::ssl;
  // Both are read here, not by OpenSSL, so that the file that is looked at is the one that is used.
  const std::string chain = ReadWholeFile(certificate, kMostBytes, "--tls-cert");
  std::string key_text = ReadWholeFile(key, kMostBytes, "--tls-key", IsPrivate("--tls-key", key));
  ssl::context context(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
  // A client that asks for new keys again and again costs much and has no need to.
  SSL_CTX_set_options(context.native_handle(), SSL_OP_NO_RENEGOTIATION);
  boost::system::error_code error;
  context.use_certificate_chain(boost::asio::buffer(chain), error);
  if (error) {
    throw Error(
        fmt::format("--tls-cert {}: {}; give the server's certificate and those between it "
                    "and its root, as PEM",
                    certificate, error.message()));
  }
  // A service has no terminal, and one that has would wait at it.
  context.set_password_callback(
      [](std::size_t, ssl::context::password_purpose) { return std::string(); });
  context.use_private_key(boost::asio::buffer(key_text), ssl::context::pem, error);
  OPENSSL_cleanse(key_text.data(), key_text.size());
  if (error) {
    throw Error(
        fmt::format("--tls-key {}: {}; give the certificate's own key, as PEM and without "
                    "a password",
                    key, error.message()));
  }
  return context;
}

}  // namespace palpate
