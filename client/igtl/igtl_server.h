#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// Sends the same bytes to all who have connected, over TCP, and lets none of them hold it up:
///   many    beyond kMostClients the address that has most of the places gives one of them to an
///           address that has fewer, and else the newcomer's own does: first of one that takes
///           nothing, then the oldest; who connects and only sits there shuts nobody out
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
    std::uint64_t refused = 0;      ///< came where each place was another address's
    std::uint64_t displaced = 0;    ///< gave its place to a newcomer
    std::uint64_t closed = 0;       ///< took nothing for too long
    std::uint64_t passed_over = 0;  ///< times that a client was too slow for
  };
  const Counts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::uint32_t address = 0;
    std::vector<std::uint8_t> rest;  ///< of messages whose beginning it has
    std::int64_t took_ns = 0;
    bool gone = false;
  };
  void Write(Client& client, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  void DropGone();
  /// False where a newcomer of that address has to go.
  bool MakeRoom(std::uint32_t address);

  int listener_ = -1;
  int port_ = 0;
  std::vector<Client> clients_;  // in the order of their coming
  Counts counts_;
};

}  // namespace palpate
