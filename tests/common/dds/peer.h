#pragma once

#include <csignal>
#include <string>

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace palpate {

/// Runs dds_peer (see dds_peer.cpp) beside the test.
class Peer {
 public:
  Peer(const std::string& transport, int domain, const std::string& topic, int count,
       const std::string& start)
      : pid_(fork()) {
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      execl(PALPATE_BIN_DIR "/dds_peer", "dds_peer", transport.c_str(),
            std::to_string(domain).c_str(), topic.c_str(), std::to_string(count).c_str(),
            start.c_str(), nullptr);
      _exit(127);
    }
  }
  ~Peer() {
    if (pid_ > 0) Wait();
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// Ends one that would stay.
  void Kill() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    if (pid_ > 0) Wait();
  }
  /// Its exit status.
  int Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  bool running() {
    int status = 0;
    if (pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) pid_ = -1;
    return pid_ > 0;
  }

 private:
  pid_t pid_;
};

}  // namespace palpate
