// Waits until a time of the wall clock, in a program whose wall clock is an hour ahead of the
// kernel's, as in a wait that began before the clock was set back.
#include <atomic>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <functional>
#include <future>
#include <thread>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

std::atomic<std::time_t> ahead_s{0};

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* time) {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (result == 0 && clock == CLOCK_REALTIME) time->tv_sec += ahead_s;
  return result;
}

namespace palpate::dds {
namespace {

class SteadyWaits : public testing::Test {
 protected:
  SteadyWaits() { ahead_s = 3600; }
  ~SteadyWaits() override { ahead_s = 0; }

  static timespec In10ms() {
    timespec time{};
    clock_gettime(CLOCK_REALTIME, &time);
    time.tv_nsec += 10'000'000;
    if (time.tv_nsec < 1'000'000'000) return time;
    return {time.tv_sec + 1, time.tv_nsec - 1'000'000'000};
  }
  /// Result of a wait that is ended after 10 s even if its time has not come.
  static int Wait(const std::function<int()>& wait, const std::function<void()>& end) {
    std::promise<void> over;
    std::thread patience([&, ended = over.get_future()] {
      if (ended.wait_for(std::chrono::seconds(10)) != std::future_status::ready) end();
    });
    const int result = wait();
    over.set_value();
    patience.join();
    return result;
  }
};

TEST_F(SteadyWaits, OfAConditionEndInTheirTimeWhereTheWallClockIsSetBack) {
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
  pthread_mutex_lock(&mutex);
  const timespec until = In10ms();
  EXPECT_EQ(Wait([&] { return pthread_cond_timedwait(&condition, &mutex, &until); },
                 [&] { pthread_cond_broadcast(&condition); }),
            ETIMEDOUT);
  pthread_mutex_unlock(&mutex);
}

TEST_F(SteadyWaits, OfASemaphoreToo) {
  sem_t semaphore;
  sem_init(&semaphore, 0, 0);
  const timespec until = In10ms();
  EXPECT_EQ(Wait([&] { return sem_timedwait(&semaphore, &until); }, [&] { sem_post(&semaphore); }),
            -1);
  EXPECT_EQ(errno, ETIMEDOUT);
  sem_destroy(&semaphore);
}

TEST_F(SteadyWaits, OfATimeThatIsOverEndAtOnce) {
  sem_t semaphore;
  sem_init(&semaphore, 0, 0);
  const timespec long_ago{1, 0};
  EXPECT_EQ(sem_timedwait(&semaphore, &long_ago), -1);
  EXPECT_EQ(errno, ETIMEDOUT);
  sem_post(&semaphore);
  EXPECT_EQ(sem_timedwait(&semaphore, &long_ago), 0) << "and is taken where it is there";
  sem_destroy(&semaphore);
}

TEST(SteadyWaitsOfLibraries, AreTheProgramsOwn) {
  Dl_info program{};
  ASSERT_NE(dladdr(&ahead_s, &program), 0);
  for (const char* const name : {"pthread_cond_timedwait", "sem_timedwait"}) {
    Dl_info found{};
    ASSERT_NE(dladdr(dlsym(RTLD_DEFAULT, name), &found), 0);
    EXPECT_EQ(found.dli_fbase, program.dli_fbase) << name;
  }
}

}  // namespace
}  // namespace palpate::dds
