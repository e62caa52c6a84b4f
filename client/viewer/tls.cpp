#include "client/viewer/tls.h"

#include <fmt/format.h>
#include <openssl/ssl.h>

#include "client/viewer/private_file.h"
#include "common/error.h"

namespace palpate {

boost::asio::ssl::context MakeTls(const std::string& certificate, const std::string& key) {
  namespace ssl = boost::asio::ssl;
  CheckPrivate("--tls-key", key);
  ssl::context context(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
  // A client that asks for new keys again and again costs much and has no need to.
  SSL_CTX_set_options(context.native_handle(), SSL_OP_NO_RENEGOTIATION);
  boost::system::error_code error;
  context.use_certificate_chain_file(certificate, error);
  if (error) {
    throw Error(
        fmt::format("--tls-cert {}: {}; give the server's certificate and those between it "
                    "and its root, as PEM",
                    certificate, error.message()));
  }
  context.use_private_key_file(key, ssl::context::pem, error);
  if (error) {
    throw Error(
        fmt::format("--tls-key {}: {}; give the certificate's own key, as PEM and without "
                    "a password",
                    key, error.message()));
  }
  return context;
}

}  // namespace palpate
