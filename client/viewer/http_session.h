#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "client/viewer/hub.h"
#include "client/viewer/page_files.h"
#include "client/viewer/scene_packer.h"
#include "client/viewer/visitor.h"
#include "client/viewer/web_stream.h"
#include "common/http/lobby.h"

namespace palpate {

/// What HTTP connections share.
struct HttpService {
  Hub& hub;
  PageFiles page;
  ScenePacker packer;
  boost::asio::ssl::context* tls;  ///< null: in the clear.  Must outlive all sessions
  std::shared_ptr<Lobby> lobby;    ///< connections may outlive this, in handlers that never run
};

/// One HTTP connection, over TLS if there is a certificate: serves files, or becomes a viewer's
/// WebSocket.  A client that is too slow is dropped: in the handshake, in sending a request,
/// between requests, and in reading an answer.
/// Thread contract: the network thread.  May outlive the hub, held by a handler that never runs.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, HttpService& service);
  ~HttpSession();

  /// Serves the connection if the lobby has room for it.
  void Begin();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  // One type for all bodies, since each instantiation of Beast is slow to compile.
  using Response = boost::beast::http::response<boost::beast::http::buffer_body>;

  /// Performs the TLS handshake; a client that speaks plain HTTP is told that TLS is required.
  void Secure();
  void Read();
  void OnBegun(boost::beast::error_code error);
  void OnRead(boost::beast::error_code error);
  void Answer(const Request& request);
  Asker AskerOf(const Request& request) const;
  /// Reports a refusal to the client and to the log.
  void Refuse(const Request& request, int status, Refusal refusal, const std::string& reason);
  /// Redirects a plain request to TLS.
  void SendToTls(const Request& request);
  void Upgrade(const Request& request);
  void GiveText(const Request& request, boost::beast::http::status status, std::string text,
                const char* type = "text/plain; charset=utf-8");
  void GiveFile(const Request& request, const std::string& path);
  void GiveScene(const Request& request, const std::string& name);
  /// Sends a file of the course by name: a score page or a picture.
  void GiveOfCourse(const Request& request,
                    std::string (ExercisePages::*find)(const std::string&) const,
                    const std::string& name);
  static Response ResponseOf(boost::beast::http::status status, const char* cache);
  static Response SceneResponse(boost::beast::http::status status, const std::string& etag);
  /// Sends the history of one person or of the class.
  void GiveHistory(const Request& request, const std::string& name, const Verdict& verdict);
  /// The part of a file still to be sent, piece by piece, after the bytes.
  struct Rest;
  /// @param owner  keeps the bytes alive.
  void Send(Response response, const Request& request, std::span<const std::uint8_t> bytes = {},
            std::shared_ptr<const void> owner = nullptr, std::shared_ptr<Rest> rest = nullptr);

  WebStream stream_;
  HttpService& service_;
  Hub& hub_;
  const std::shared_ptr<Lobby> lobby_;
  boost::asio::ip::tcp::endpoint peer_;
  Visitor visitor_;  // of the last request: a proxy may forward several over one connection
  std::optional<Lobby::Id> place_;
  bool answered_ = false;  // at least one request
  bool last_ = false;      // the connection ends with this answer
  boost::beast::flat_buffer input_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
};

}  // namespace palpate
