#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "client/viewer/hub.h"
#include "client/viewer/visitor.h"
#include "client/viewer/web_stream.h"
#include "common/http/lobby.h"

namespace palpate {

/// One connection that speaks HTTP, over TLS where there is a certificate: gives files, or becomes
/// a viewer's WebSocket.  Whoever is slow is given up: with shaking hands, with a request, between
/// two of them, and with taking an answer. Thread contract: the network thread.  May outlive the
/// hub, within a handler that never runs.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  /// @param tls  null: in the clear.  Outlives all sessions.
  HttpSession(boost::asio::ip::tcp::socket socket, Hub& hub, std::shared_ptr<Lobby> lobby,
              boost::asio::ssl::context* tls);
  ~HttpSession();

  /// Serves the connection, where the lobby has room for it.
  void Begin();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  // Of one type, whatever it holds: what Beast makes of each is much to compile.
  using Response = boost::beast::http::response<boost::beast::http::buffer_body>;

  /// Shakes hands with who wants TLS; who does not is told that it is spoken here.
  void Secure();
  void Read();
  void OnBegun(boost::beast::error_code error);
  void OnRead(boost::beast::error_code error);
  void Answer(const Request& request);
  Asker AskerOf(const Request& request) const;
  /// Tells of a refusal: whoever asks, and the log.
  void Refuse(const Request& request, int status, Refusal refusal, const std::string& reason);
  /// Where TLS is spoken, to who asked in the clear.
  void SendToTls(const Request& request);
  void Upgrade(const Request& request);
  void GiveText(const Request& request, boost::beast::http::status status, std::string text,
                const char* type = "text/plain; charset=utf-8");
  void GiveFile(const Request& request, const std::string& path);
  void GiveScene(const Request& request, const std::string& name);
  /// What a course has by that name: a score page, or a picture.
  void GiveOfCourse(const Request& request,
                    std::string (TrialRoom::*find)(const std::string&) const,
                    const std::string& name);
  static Response ResponseOf(boost::beast::http::status status, const char* cache);
  static Response SceneResponse(boost::beast::http::status status, const std::string& etag);
  /// What a course has of a person's trials, or of all.
  void GiveHistory(const Request& request, const std::string& name, const Verdict& verdict);
  /// What is sent from a file, a piece at a time, behind the bytes.
  struct Rest;
  /// @param owner  keeps the bytes alive.
  void Send(Response response, const Request& request, std::span<const std::uint8_t> bytes = {},
            std::shared_ptr<const void> owner = nullptr, std::shared_ptr<Rest> rest = nullptr);

  WebStream stream_;
  Hub& hub_;
  std::shared_ptr<Lobby> lobby_;
  boost::asio::ssl::context* tls_;
  boost::asio::ip::tcp::endpoint peer_;
  Visitor visitor_;  // of the last request: a proxy may ask for several over one connection
  std::optional<Lobby::Id> place_;
  bool answered_ = false;  // one request at least
  bool last_ = false;      // the connection ends with this answer
  boost::beast::flat_buffer input_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
};

}  // namespace palpate
