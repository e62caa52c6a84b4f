#pragma once

#include <csignal>
#include <string>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {

/// Runs dds_peer (see dds_peer.cpp) beside the test.
class Peer {
 public:
  Peer(const std::string& transport, int domain, const std::string& topic, int count,
       const std::string& start) {
    int to_peer[2], from_peer[2];
    if (pipe2(to_peer, O_CLOEXEC) != 0 || pipe2(from_peer, O_CLOEXEC) != 0) {
      throw Error("no pipe to dds_peer");
    }
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(to_peer[0], STDIN_FILENO);
      dup2(from_peer[1], STDOUT_FILENO);
      execl(PALPATE_BIN_DIR "/dds_peer", "dds_peer", transport.c_str(),
            std::to_string(domain).c_str(), topic.c_str(), std::to_string(count).c_str(),
            start.c_str(), nullptr);
      _exit(127);
    }
    close(to_peer[0]);
    close(from_peer[1]);
    in_ = to_peer[1];
    out_ = from_peer[0];
  }
  ~Peer() {
    if (pid_ > 0) Wait();
    close(out_);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// For a peer that writes in step: lets it write its next sample.  True once that is written,
  /// false if the peer has ended.
  bool Next() {
    const char go = '.';
    char done = 0;
    return write(in_, &go, 1) == 1 && read(out_, &done, 1) == 1 && done == '.';
  }
  /// For a peer that writes in step: ends it.
  void End() {
    if (in_ >= 0) close(in_);
    in_ = -1;
  }

  /// Ends a peer that would stay.
  void Kill() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    if (pid_ > 0) Wait();
  }
  /// Its exit status.
  int Wait() {
    End();
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
  pid_t pid_ = -1;
  int in_ = -1;
  int out_ = -1;
};

}  // namespace palpate
