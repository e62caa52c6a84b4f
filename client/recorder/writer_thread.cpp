#include "client/recorder/writer_thread.h"

#include <chrono>
#include <new>

#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kDrain{20};
constexpr std::int64_t kFlush_ns = 200'000'000;
/// A recorder that is killed loses at most the samples since the last flush: this period and
/// one pass through the loop.  The rest of the half second is a margin for the flush itself, for
/// the mark of an exam's gateway (client/course/exam_seals.cpp), and for a busy machine.
static_assert(kFlush_ns + std::chrono::nanoseconds(kDrain).count() <= 250'000'000,
              "at most half a second is lost, with half of it to spare");

std::string WordsOf(const std::exception_ptr& error, const std::string& file) {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    return file + ": there is no memory left to record with; end other programs, or record less";
  } catch (const std::exception& known) {
    return known.what();
  } catch (...) {
    return file + ": writing failed for an unknown reason";
  }
}

}  // namespace

WriterThread::WriterThread(RecordingWriter& recording, SampleQueue& queue, TappedTopics& topics)
    : recording_(recording), queue_(queue), topics_(topics), thread_([this] { Run(); }) {}

WriterThread::~WriterThread() {
  Stop();
}

void WriterThread::Stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void WriterThread::Finish(const std::string& reason) {
  Stop();
  if (!failed_) {
    recording_.Close(reason);
    return;
  }
  // Frees memory, since closing the file needs some.
  std::vector<std::uint8_t>().swap(drained_);
  std::string what = WordsOf(error_, recording_.files().back());
  try {
    recording_.Close("a write failed");
    what += " (the recording up to then is complete, with its index)";
  } catch (const std::exception&) {
    what += " (the recording up to then is complete, without an index)";
  }
  throw Error(what);
}

void WriterThread::Run() {
  try {
    std::int64_t flushed_ns = SteadyNanoseconds();
    bool last = false;
    while (!last) {
      last = stop_;
      if (!last) std::this_thread::sleep_for(kDrain);
      queue_.Swap(drained_);
      SampleQueue::ForEach(drained_, [&](const SampleQueue::Head& head, auto bytes) {
        const TappedTopic& topic = topics_[head.channel];
        recording_.Add(topic.name, topic.type, head.time_ns, bytes);
      });
      Count();
      const std::int64_t now_ns = SteadyNanoseconds();
      if (now_ns - flushed_ns >= kFlush_ns || last) {
        recording_.Flush();
        flushed_ns = now_ns;
      }
    }
  } catch (...) {
    // A thread must not throw: Finish rethrows it.
    error_ = std::current_exception();
    failed_ = true;
  }
}

void WriterThread::Count() {
  std::uint64_t dropped = 0;
  for (std::uint32_t i = 0; i < topics_.size(); ++i) {
    const TappedTopic& topic = topics_[i];
    const std::uint64_t of_topic = topic.dropped.load(std::memory_order_relaxed);
    if (of_topic > 0) recording_.SetDropped(topic.name, topic.type, of_topic);
    dropped += of_topic;
  }
  totals_.messages = recording_.messages();
  totals_.bytes = recording_.bytes();
  totals_.missing = recording_.missing();
  totals_.dropped = dropped;
}

}  // namespace palpate
