#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "client/recorder/sample_queue.h"
#include "common/recording/recording_writer.h"

namespace palpate {

/// Writes what comes out of the queue, in a thread of its own: a disk may stand still for seconds.
class WriterThread {
 public:
  struct Totals {
    std::atomic<std::uint64_t> messages{0}, bytes{0}, missing{0}, dropped{0};
  };

  WriterThread(RecordingWriter& recording, SampleQueue& queue, TappedTopics& topics);
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// True once writing has failed, whatever it was; nothing more is written then.
  bool failed() const { return failed_; }
  const Totals& totals() const { return totals_; }

  /// Writes what is left, and closes the recording, also where writing has failed; then throws
  /// Error, with what went wrong and in what state the file is.
  /// @param reason  why it ends, in words.
  void Finish(const std::string& reason);

 private:
  void Stop();
  void Run();
  void Count();

  RecordingWriter& recording_;
  SampleQueue& queue_;
  TappedTopics& topics_;
  std::vector<std::uint8_t> drained_;
  Totals totals_;
  std::atomic<bool> stop_{false}, failed_{false};
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace palpate
