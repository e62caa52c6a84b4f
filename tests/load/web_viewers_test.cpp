#include "client/load/web_viewers.h"

#include <future>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/support/complaint.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Something at a port of this host that is no gateway: takes one connection and says `answer`.
class Stranger {
 public:
  explicit Stranger(const std::string& answer) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    socklen_t size = sizeof address;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    listen(socket_, 1);
    served_ = std::async(std::launch::async, [this, answer] {
      const int client = accept(socket_, nullptr, nullptr);
      char request[4096];
      if (recv(client, request, sizeof request, 0) > 0) {
        send(client, answer.data(), answer.size(), MSG_NOSIGNAL);
      }
      close(client);
    });
  }
  ~Stranger() {
    served_.wait();
    close(socket_);
  }
  int port() const { return port_; }

 private:
  int socket_;
  int port_ = 0;
  std::future<void> served_;
};

std::string ComplaintAbout(const std::string& answer) {
  const Stranger stranger(answer);
  FrameTally tally({1, 0, "load", 30.0, {}, {}});
  StopSignal stop;
  return test::ComplaintOf([&] {
    const WebViewers viewers({"127.0.0.1", stranger.port()}, 1, 0, 20.0, tally, stop);
  });
}

TEST(WebViewers, TellAnotherServerAndAFullGatewayFromNone) {
  EXPECT_THAT(ComplaintAbout("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"),
              AllOf(HasSubstr("what answers at ws://127.0.0.1:"), HasSubstr("is no palpate-viewer"),
                    HasSubstr("HTTP status 404")));
  EXPECT_THAT(ComplaintAbout("SSH-2.0-OpenSSH\r\n"), HasSubstr("is no palpate-viewer"));
  EXPECT_THAT(ComplaintAbout("HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n"),
              AllOf(HasSubstr("turns viewers away (HTTP status 503)"), HasSubstr("--max-viewers")));
}

}  // namespace
}  // namespace palpate
