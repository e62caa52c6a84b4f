#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace palpate::test {

/// What a client sees of spacenavd: a UNIX socket in a temporary folder, named in SPNAV_SOCKET
/// while the object lives.  Frames are eight 32-bit words: a type, then what belongs to it.
class FakeSpacenavd {
 public:
  struct Options {
    int protocol = 1;        ///< 0: answers no questions, as daemons before 1.0
    bool has_device = true;  ///< of protocol 1
    int early_frames = 0;    ///< number of connections that get an event before any answer
  };
  explicit FakeSpacenavd(Options options);
  FakeSpacenavd() : FakeSpacenavd(Options{}) {}
  ~FakeSpacenavd();

  /// Dies like a killed process: the connection breaks, the socket's file stays.
  void Kill();
  void Start() { Start(options_); }
  void Start(Options options);
  const std::string& path() const { return path_; }
  bool connected() const { return client_.load() >= 0; }

  // Events to the connected client.
  void Push(const std::array<int, 6>& axes) {
    Send({0, axes[0], axes[1], axes[2], axes[3], axes[4], axes[5], 16});
  }
  void Press(int button, bool down) { Send({down ? 1 : 2, button, down, 0, 0, 0, 0, 0}); }
  void Unplug() { Send({3, 1, 0, 0, 0, 0, 0, 0}); }
  void PlugIn() { Send({3, 0, 0, 0, 0, 0, 0, 0}); }
  void Send(const std::array<std::int32_t, 8>& frame);
  /// Sends two pieces; the first is read before the second comes.
  void SendInPieces(const std::array<std::int32_t, 8>& frame);
  /// All in one send, as the reader may hang up at any of them.
  void SendOften(const std::array<std::int32_t, 8>& frame, int times);
  /// Sends the beginning alone.
  void SendHalf(const std::array<std::int32_t, 8>& frame);

 private:
  void Serve();
  void SendBytes(const char* bytes, std::size_t count);
  void Converse(int client);

  Options options_;
  std::string folder_, path_;
  int listener_ = -1;
  int stop_ = -1;  // eventfd
  std::atomic<int> client_{-1};
  std::mutex sending_;
  std::thread thread_;
};

}  // namespace palpate::test
