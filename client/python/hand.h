#pragma once

#include <cstdint>
#include <optional>
#include <thread>
#include <utility>

#include "client/python/arrays.h"
#include "client/python/held_wrench.h"
#include "client/python/model.h"

namespace palpate {

/// A force in Python attached to a proxy: called once every few steps, held in between.
struct SlowEffect {
  struct Memory {
    HeldWrench held;
    EffectState motion{};  // of the hand, with the number of its steps
  };
  py::object ask;
  Memory memory;

  /// Takes over a memory, but keeps its own rate and limits.
  void Remember(const Memory& from) {
    const HeldWrench own = memory.held;
    memory = from;
    memory.held.every = own.every;
    memory.held.max_force_N = own.max_force_N;
    memory.held.max_torque_Nm = own.max_torque_Nm;
  }
};

struct Hand {
  Hand(Shared m, const Pose& X_WH) : shared(std::move(m)), proxy(*shared.model, X_WH) {}
  Hand(Shared m, const ProxyState& state)
      : shared(std::move(m)), proxy(*shared.model, state.step, state.start_depth) {}

  void Restart(const Pose& X_WH) {
    proxy.Restart(X_WH);
    if (effect) effect->memory.motion = {};
  }
  /// Takes a step, without Python's lock except while it calls an effect.  If the effect raises,
  /// throws that, switches the effect off, and takes no step.
  StepReport Step(const Pose& X_WH, StageTimes* times = nullptr) {
    const bool acts = effect && IsPose(X_WH);
    if (acts) LookAt(X_WH);
    StepReport report = proxy.Step(X_WH, times);
    if (!acts) return report;
    const Pose& X = effect->memory.motion.X_WH;
    Wrench given = effect->memory.held.At(X);
    given.torque -= (X.q * shared.model->reference()).cross(given.force);
    for (Wrench* sum : {&report.wrench, &report.effects.active}) {
      *sum = {sum->force + given.force, sum->torque + given.torque};
    }
    return report;
  }

  Shared shared;  // declared first: outlives the proxy
  Proxy proxy;
  std::optional<SlowEffect> effect{};
  std::thread::id stepping{};  // which thread does; guarded by Python's lock

 private:
  void LookAt(const Pose& X_WH) {
    auto& [held, motion] = effect->memory;
    Follow({X_WH.p, X_WH.q.normalized()}, motion);
    if (motion.cycle++ % held.every != 0) return;
    const py::gil_scoped_acquire lock;
    try {
      Ask(effect->ask, motion.X_WH, motion.V_WH, proxy.X_WG(), held);
    } catch (...) {
      effect.reset();
      throw;
    }
  }
};

/// Prevents other threads, and its own effect, from using a proxy while its step has released
/// Python's lock.  Made and destroyed with that lock.
class Busy {
 public:
  /// @param by  the thread that uses it; none between calls
  explicit Busy(std::thread::id& by) : by_(by) {
    if (by == std::this_thread::get_id()) {
      throw Error(
          "proxy: an effect cannot step or change the proxy that calls it; let it compute with "
          "another proxy of the model, or change this one after the step");
    }
    if (by != std::thread::id()) {
      throw Error("proxy: another thread is stepping it; give each thread a proxy of its own");
    }
    by = std::this_thread::get_id();
  }
  ~Busy() { by_ = {}; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  std::thread::id& by_;
};

}  // namespace palpate
