#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// Sends the same bytes to all connected clients over TCP, such that no client can delay it:
///   many    beyond kMostClients, the address with the most connections gives one up to an address
///           that has fewer; otherwise the newcomer's own address does.  A client that reads
///           nothing goes first, then the oldest, so idle connections lock nobody out
///   slow    a client gets whole messages or none: until it has taken the last ones, newer ones are
///           skipped; after kPatience_ns without taking a byte it is closed
///   hostile what a client sends is read in small amounts and discarded
/// Thread contract: one thread.
class IgtlServer {
 public:
  static constexpr std::size_t kMostClients = 16;
  static constexpr std::int64_t kPatience_ns = 10'000'000'000;

  /// @param address  numeric address of this host.   @param port  0: any free port.
  /// Throws Error (address and port, the system's reason).
  IgtlServer(const std::string& address, int port);
  ~IgtlServer();
  IgtlServer(const IgtlServer&) = delete;
  IgtlServer& operator=(const IgtlServer&) = delete;

  /// Accepts new clients and discards what clients have sent.  Never blocks.
  void Poll(std::int64_t now_ns);
  /// @param messages  whole messages.  Never blocks.
  void Send(std::span<const std::uint8_t> messages, std::int64_t now_ns);

  int port() const { return port_; }
  std::size_t clients() const { return clients_.size(); }
  struct Counts {
    std::uint64_t refused = 0;      ///< refused because other addresses hold all places
    std::uint64_t displaced = 0;    ///< gave up its place to a newcomer
    std::uint64_t closed = 0;       ///< closed because it took nothing for too long
    std::uint64_t passed_over = 0;  ///< times that messages were skipped for a slow client
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::uint32_t address = 0;
    std::vector<std::uint8_t> rest;  ///< the rest of messages whose beginning was sent
    std::int64_t took_ns = 0;
    bool gone = false;
  };
  void Write(Client& client, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  void DropGone();
  /// Returns false if a newcomer from that address has to be refused.
  bool MakeRoom(std::uint32_t address);

  int listener_ = -1;
  int port_ = 0;
  std::vector<Client> clients_;  // in order of connection
  Counts counts_;
};

}  // namespace palpate
