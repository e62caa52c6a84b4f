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

/// Writes the queued samples in a thread of its own, since a disk may stall for seconds.
class WriterThread {
 public:
  struct Totals {
    std::atomic<std::uint64_t> messages{0}, bytes{0}, missing{0}, dropped{0};
  };

  WriterThread(RecordingWriter& recording, SampleQueue& queue, TappedTopics& topics);
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// True once writing has failed for any reason; nothing more is written then.
  bool failed() const { return failed_; }
  const Totals& totals() const { return totals_; }

  /// Writes the remaining samples and closes the recording, even if writing has failed; in that
  /// case throws Error with the cause and the state of the file.
  /// @param reason  why the recording ends, in words.
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
