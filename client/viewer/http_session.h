#pragma once

#include <memory>
#include <optional>
#include <string>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "client/viewer/hub.h"
#include "client/viewer/lobby.h"

namespace palpate {

/// One connection that speaks HTTP: gives files, or becomes a viewer's WebSocket.  Whoever is slow
/// is given up: with a request, between two of them, and with taking an answer.
/// Thread contract: the network thread.  May outlive the hub, within a handler that never runs.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub, std::shared_ptr<Lobby> lobby);
  ~HttpSession();

  /// Serves the connection, where the lobby has room for it.
  void Begin();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  void Read();
  void OnBegun(boost::beast::error_code error);
  void OnRead(boost::beast::error_code error);
  void Answer(const Request& request);
  void Upgrade(const Request& request);
  void GiveText(const Request& request, boost::beast::http::status status, std::string text,
                const char* type = "text/plain; charset=utf-8");
  void GiveFile(const Request& request, const std::string& path);
  void GiveScene(const Request& request, const std::string& name);
  /// @param owner  keeps the bytes alive.
  void GiveBytes(const Request& request, std::shared_ptr<const void> owner,
                 std::span<const std::uint8_t> bytes, std::uint64_t hash, bool gzip);
  template <class Body>
  void Send(boost::beast::http::response<Body> response, const Request& request,
            std::shared_ptr<const void> owner = nullptr);

  boost::beast::tcp_stream stream_;
  Hub& hub_;
  std::shared_ptr<Lobby> lobby_;
  std::optional<Lobby::Id> place_;
  bool answered_ = false;  // one request at least
  bool last_ = false;      // the connection ends with this answer
  boost::beast::flat_buffer input_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
};

}  // namespace palpate
