#include "client/python/workers.h"

#include <atomic>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/library/physics.h"

namespace palpate {
namespace {

TEST(Workers, MakeEachCallOnceOnAsManyThreadsAsAskedFor) {
  for (const int threads : {1, 2, 5}) {
    Workers workers(threads);
    for (const std::size_t count : {0u, 1u, 3u, 100u}) {
      std::vector<std::atomic<int>> calls(count);
      workers.Run(count, [&](std::size_t i, std::size_t thread) {
        EXPECT_LT(thread, static_cast<std::size_t>(threads));
        ++calls[i];
      });
      for (const auto& times : calls) EXPECT_EQ(times, 1);
      EXPECT_FALSE(workers.has_failed());
    }
  }
}

TEST(Workers, ThrowWhatACallThrowsAndBeginNoOther) {
  Workers workers(3);
  std::atomic<int> calls{0};
  const auto fail = [&](std::size_t, std::size_t) {
    ++calls;
    throw std::runtime_error("enough");
  };
  EXPECT_THROW(workers.Run(1000, fail), std::runtime_error);
  EXPECT_LE(calls, 3);
  EXPECT_TRUE(workers.has_failed());
  calls = 0;
  workers.Run(50, [&](std::size_t, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 50);
}

TEST(Workers, EndWhenTheWaitForTheOthersThrows) {
  Workers workers(2);
  // The caller's own call ends at once, the other lasts until the loop has failed.
  const auto work = [&](std::size_t, std::size_t thread) {
    while (thread != 0 && !workers.has_failed()) std::this_thread::yield();
  };
  std::atomic<bool> other{false};
  const auto both = [&](std::size_t i, std::size_t thread) {
    if (thread != 0) other = true;
    while (thread == 0 && !other) std::this_thread::yield();
    work(i, thread);
  };
  EXPECT_THROW(workers.Run(2, both, [] { throw std::runtime_error("Ctrl-C"); }),
               std::runtime_error);
}

TEST(Workers, WorkInAForkedChildAndAfterItInTheParent) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer begins no threads after a fork";
#endif
  Workers workers(3);
  const auto sum = [&] {
    std::atomic<std::size_t> sum{0};
    workers.Run(100, [&](std::size_t i, std::size_t) { sum += i; });
    return sum.load();
  };
  EXPECT_EQ(sum(), 4950u);
  const pid_t child = fork();
  if (child == 0) _exit(sum() == 4950 ? 0 : 1);
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(sum(), 4950u);
}

TEST(Workers, StepProxiesToTheBitsOfASingleThread) {
  Scene scene;
  scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04}),
                                   {.leaves = 64, .material = {INFINITY, 0.5, 0.3}}));
  scene.features.friction = FrictionModel::kCoulomb;
  scene.tools.push_back(MakeBody("probe", MakeBox({0.01, 0.01, 0.01}), {.leaves = 64}));
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  constexpr std::size_t kProxies = 12;
  const auto at = [](std::size_t i, int step) {
    return Pose{Vec3(1e-3 * double(i), 0.0266 - 4e-5 * step, 3e-5 * step),
                RotationExp(Vec3(0.0, 1e-3 * step, 2e-2 * double(i)))};
  };
  const auto felt = [&](int threads) {
    Workers workers(threads);
    std::vector<std::unique_ptr<Proxy>> proxies(kProxies);
    std::vector<Wrench> wrenches(kProxies);
    workers.Run(kProxies, [&](std::size_t i, std::size_t) {
      proxies[i] = std::make_unique<Proxy>(model, at(i, 0));
    });
    for (int step = 0; step < 80; ++step) {
      workers.Run(kProxies, [&](std::size_t i, std::size_t) {
        wrenches[i] = proxies[i]->Step(at(i, step)).wrench;
      });
    }
    return wrenches;
  };
  const std::vector<Wrench> one = felt(1);
  EXPECT_GT(one[0].force.norm(), 0.5);
  for (const int threads : {2, 4}) {
    const std::vector<Wrench> many = felt(threads);
    EXPECT_EQ(std::memcmp(many.data(), one.data(), sizeof(Wrench) * kProxies), 0) << threads;
  }
}

}  // namespace
}  // namespace palpate
