// Your own servo loop, at 1 kHz by the absolute clock.  It simulates a hand and discards the force.
// Replace these by reading and commanding your arm.  The limiter stays in front of it: a proxy
// returns the force of its spring, however large it is for the arm.  However the loop is ended, it
// ends with the force at zero: most arms keep the last command.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <palpate/devices/wrench_limiter.h>
#include <palpate/physics.h>

namespace {
volatile std::sig_atomic_t stopped = 0;
}

int main(int argc, char** argv) {
  using namespace palpate;
  const double seconds = argc > 1 ? std::atof(argv[1]) : 2.0;
  Scene scene;
  scene.objects.push_back(MakeBody("egg", MakeEllipsoid({0.03, 0.02, 0.02}, 5000)));
  scene.tools.push_back(MakeBall("ball", 0.004));
  scene.coupling.stiffness = 800.0;  // N/m: as stiff as your arm holds without vibrating
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  Pose X_WH;
  X_WH.p = {0.0, 0.03, 0.0};
  Proxy proxy(model, X_WH);  // all allocations are done by here
  DeviceInfo arm;            // your arm's data sheet
  arm.max_force_N = 3.0, arm.continuous_force_N = 1.0;
  arm.max_torque_Nm = 0.2, arm.continuous_torque_Nm = 0.05;
  WrenchLimiter limiter(WrenchLimits::Of(arm));
  limiter.SetStiffness(scene.coupling.stiffness);

  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) {
    std::signal(signal, [](int) { stopped = 1; });
  }

  using Clock = std::chrono::steady_clock;
  auto next = Clock::now();
  std::chrono::duration<double, std::micro> worst{};
  double strongest_N = 0.0;
  const int steps = static_cast<int>(1000.0 * seconds);
  bool holds_force = false;
  for (int i = 0; (i < steps && !stopped) || holds_force; ++i) {
    limiter.Enable(i < steps && !stopped);
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
    const double t = 1e-3 * i;
    X_WH.p = {0.01 * std::sin(2.0 * t), 0.026 - 0.005 * std::sin(5.0 * t), 0.0};  // your arm's pose
    const auto before = Clock::now();
    const StepReport report = proxy.Step(X_WH);
    // At the handle, which is where this ball's centroid is.
    const LimiterInput felt{
        .wanted = report.wrench, .X_WH = X_WH, .silence_s = 0.0, .age_s = 0.0, .dt_s = 1e-3};
    const Wrench force = limiter.Limit(felt).wrench();  // command your arm with this
    holds_force = !force.force.isZero(0.0);
    worst = std::max<decltype(worst)>(worst, Clock::now() - before);
    strongest_N = std::max(strongest_N, force.force.norm());
    if (report.faults != kFaultNone) std::printf("%s\n", FaultWords(report.faults).c_str());
  }
  std::printf("%d steps, longest %.0f us, strongest force %.2f N\n", steps, worst.count(),
              strongest_N);
}
