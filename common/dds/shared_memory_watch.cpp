#include "common/dds/shared_memory_watch.h"

#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <utility>

namespace palpate::dds {
namespace {

constexpr int kLooks = 20;

}  // namespace

SharedMemoryWatch::SharedMemoryWatch(std::string doing, std::chrono::milliseconds patience)
    : thread_([doing = std::move(doing), patience](const std::stop_token& done) {
        std::mutex mutex;
        std::condition_variable_any wake;
        std::unique_lock lock(mutex);
        for (int i = 0; i < kLooks; ++i) {
          if (wake.wait_for(lock, done, patience / kLooks, [&] { return done.stop_requested(); })) {
            return;
          }
        }
        std::fprintf(stderr,
                     "shared memory hangs (%s): a process died during a write and left it locked, "
                     "also for RouDi; restart iox-roudi, then the server and all stations\n",
                     doing.c_str());
        std::_Exit(1);
      }) {}

}  // namespace palpate::dds
