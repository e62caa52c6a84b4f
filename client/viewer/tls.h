#pragma once

#include <string>

#include <boost/asio/ssl/context.hpp>

namespace palpate {

/// TLS 1.2 and newer, with a server's certificate chain and its key, both PEM.  Throws Error, which
/// names the flag and the file.
boost::asio::ssl::context MakeTls(const std::string& certificate, const std::string& key);

}  // namespace palpate
