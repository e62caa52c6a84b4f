#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

namespace palpate::test {

/// A host without an identity on the network of those that have one: hears what is sent to some UDP
/// ports, and sends it again from a bare socket.  Hearing takes CAP_NET_RAW.
class Eavesdropper {
 public:
  Eavesdropper(int first_port, int last_port) : first_(first_port), last_(last_port) {
    const timeval patience{5, 0};
    setsockopt(ears_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Eavesdropper() {
    if (ears_ >= 0) close(ears_);
    close(mouth_);
  }
  Eavesdropper(const Eavesdropper&) = delete;
  Eavesdropper& operator=(const Eavesdropper&) = delete;

  bool hears() const { return ears_ >= 0; }

  /// Sends each of the next `messages` again: unchanged and, where it shows a sample's number, with
  /// the next number and with one a thousand higher.  Returns how many messages of RTPS it heard.
  int SendAgain(int messages) {
    int heard = 0;
    std::array<std::uint8_t, 65536> packet;
    while (heard < messages) {
      const ssize_t size = recv(ears_, packet.data(), packet.size(), 0);
      if (size < 0) return heard;
      const std::size_t ip = 4u * (packet[0] & 15u);
      const auto port_at = [&](std::size_t at) { return packet[at] << 8 | packet[at + 1]; };
      const int to = port_at(ip + 2);
      const std::span message = std::span(packet).subspan(
          ip + sizeof(udphdr), static_cast<std::size_t>(size) - ip - sizeof(udphdr));
      if (to < first_ || to > last_ || message.size() < kHeader ||
          std::memcmp(message.data(), "RTPS", 4) != 0 || port_at(ip) == own_port_) {
        continue;
      }
      ++heard;
      Send(message, to);
      if (std::uint8_t* const number = SampleNumber(message)) {
        std::uint32_t low;
        std::memcpy(&low, number, sizeof low);
        for (const std::uint32_t skipped : {1u, 1000u}) {
          const std::uint32_t later = low + skipped;
          std::memcpy(number, &later, sizeof later);
          Send(message, to);
        }
      }
    }
    return heard;
  }

 private:
  static constexpr std::size_t kHeader = 20;
  static constexpr std::uint8_t kData = 0x15;

  /// Offset of the low half (little-endian) of the sample number in the first DATA that is not
  /// discovery's (RTPS 2.3, 8.3.7.2).
  static std::uint8_t* SampleNumber(std::span<std::uint8_t> message) {
    for (std::size_t at = kHeader; at + 24 <= message.size();) {
      const std::size_t length = message[at + 2] | message[at + 3] << 8;
      const bool builtin = (message[at + 15] & 0xc0) == 0xc0;
      if (message[at] == kData && !builtin) return &message[at + 20];
      if (length == 0) break;
      at += 4 + length;
    }
    return nullptr;
  }
  void Send(std::span<const std::uint8_t> message, int port) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(static_cast<std::uint16_t>(port));
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sendto(mouth_, message.data(), message.size(), 0, reinterpret_cast<sockaddr*>(&place),
           sizeof place);
    socklen_t size = sizeof place;
    getsockname(mouth_, reinterpret_cast<sockaddr*>(&place), &size);
    own_port_ = ntohs(place.sin_port);
  }

  int first_, last_, own_port_ = -1;
  int ears_ = socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_UDP);
  int mouth_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

}  // namespace palpate::test
