#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// Sends the same bytes to all who have connected, over TCP, and lets none of them hold it up:
///   many    those beyond kMostClients are closed at once
///   slow    gets whole messages or none: while it has not taken the last ones, newer ones are
///           passed over; after kPatience_ns without taking a byte it is closed
///   hostile what it sends is read and thrown away, a little at a time
/// Thread contract: one thread.
class IgtlServer {
 public:
  static constexpr std::size_t kMostClients = 16;
  static constexpr std::int64_t kPatience_ns = 10'000'000'000;

  /// @param address  of this host, in numbers.   @param port  0: any that is free.
  /// Throws Error (address and port, the system's reason).
  IgtlServer(const std::string& address, int port);
  ~IgtlServer();
  IgtlServer(const IgtlServer&) = delete;
  IgtlServer& operator=(const IgtlServer&) = delete;

  /// Takes in who wants to come, and throws away what clients have sent.  Never waits.
  void Poll(std::int64_t now_ns);
  /// @param messages  whole ones.   Never waits.
  void Send(std::span<const std::uint8_t> messages, std::int64_t now_ns);

  int port() const { return port_; }
  std::size_t clients() const { return clients_.size(); }
  struct Counts {
    std::uint64_t refused = 0;      ///< came where there was no room
    std::uint64_t closed = 0;       ///< took nothing for too long
    std::uint64_t passed_over = 0;  ///< times that a client was too slow for
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::vector<std::uint8_t> rest;  ///< of messages whose beginning it has
    std::int64_t took_ns = 0;
    bool gone = false;
  };
  void Write(Client& client, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  void DropGone();

  int listener_ = -1;
  int port_ = 0;
  std::vector<Client> clients_;
  Counts counts_;
};

}  // namespace palpate
