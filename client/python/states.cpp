#include "client/python/states.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>

#include "client/python/arrays.h"
#include "common/revision.h"

// The states of proxies: kept, copied, and pickled.

namespace palpate {
namespace {

/// The numbers of an effect's memory: the held wrench and its stiffness, where it was asked, and
/// the hand's motion.
constexpr std::size_t kEffectNumbers = 6 + 36 + 7 + 7 + 6 + 1;

template <class Memory, class Visit>
void ForEachNumber(Memory& memory, Visit visit) {
  auto& [held, motion] = memory;
  visit(held.wrench.force);
  visit(held.wrench.torque);
  visit(held.stiffness);
  for (auto* pose : {&held.X_WH, &motion.X_WH}) {
    visit(pose->p);
    visit(pose->q.coeffs());
  }
  visit(motion.V_WH.v);
  visit(motion.V_WH.w);
}

py::object ToNumbers(const std::optional<SlowEffect::Memory>& memory) {
  if (!memory) return py::none();
  std::vector<double> numbers;
  ForEachNumber(*memory, [&](const auto& part) {
    numbers.insert(numbers.end(), part.data(), part.data() + part.size());
  });
  numbers.push_back(static_cast<double>(memory->motion.cycle));
  return FromNumbers(numbers.data(), static_cast<py::ssize_t>(numbers.size()));
}

std::optional<SlowEffect::Memory> ToMemory(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  const Doubles numbers = ToDoubles(given, "pickle: the State's effect");
  const double* number = numbers.data();
  SlowEffect::Memory memory;
  const double cycle = numbers.size() == kEffectNumbers ? number[kEffectNumbers - 1] : -1.0;
  if (!(cycle >= 0.0 && cycle < 1e15)) throw Error("pickle: the State is damaged; store it again");
  ForEachNumber(memory, [&](auto&& part) {
    std::copy_n(number, part.size(), part.data());
    number += part.size();
  });
  memory.motion.cycle = static_cast<std::uint64_t>(cycle);
  return memory;
}

py::tuple Pickle(const State& state) {
  py::bytes bytes(state.bytes);
  if (state.model) {
    const auto stored = ToBytes(*state.model, state.proxy);
    bytes = py::bytes(reinterpret_cast<const char*>(stored.data()), stored.size());
  }
  return py::make_tuple(kPhysicsRevision, bytes, ToNumbers(state.effect));
}

State UnpickleState(const py::tuple& stored) {
  if (stored.size() != 3) throw Error("pickle: the State is damaged; store it again");
  RequireRevision(stored[0], "State");
  return {nullptr, {}, stored[1].cast<std::string>(), ToMemory(stored[2])};
}

}  // namespace

void RequireRevision(const py::object& revision, const char* what) {
  const auto text = py::str(revision).cast<std::string>();
  if (text == kPhysicsRevision) return;
  throw Error(std::string("pickle: the ") + what + " is of physics " + text + ", this is physics " +
              kPhysicsRevision + "; load it with that build, or make it again");
}

State StateOf(Hand& hand) {
  const Busy busy(hand.stepping);
  State state{hand.shared.model, {hand.proxy.state(), hand.proxy.start_depth()}, "", {}};
  if (hand.effect) state.effect = hand.effect->memory;
  return state;
}

void SetState(Hand& hand, const State& state) {
  const Busy busy(hand.stepping);
  const HapticModel& model = *hand.shared.model;
  if (!state.model) {
    const ProxyState stored = StateOf(
        model, {reinterpret_cast<const std::uint8_t*>(state.bytes.data()), state.bytes.size()});
    hand.proxy.set_state(stored.step, stored.start_depth);
  } else {
    // What was cut of solids refers to its model's solids.
    const bool is_same = state.model == hand.shared.model ||
                         (model.solids().empty() && ContentOf(*state.model) == ContentOf(model));
    if (!is_same) {
      throw Error(
          "state: is of another model; give it to a proxy of the same tool, objects and "
          "parameters");
    }
    hand.proxy.set_state(state.proxy.step, state.proxy.start_depth);
  }
  if (hand.effect) hand.effect->Remember(state.effect.value_or(SlowEffect::Memory{}));
}

std::unique_ptr<Hand> Copy(Hand& hand) {
  const Busy busy(hand.stepping);
  auto copy =
      std::make_unique<Hand>(hand.shared, ProxyState{hand.proxy.state(), hand.proxy.start_depth()});
  copy->effect = hand.effect;
  return copy;
}

void DefineStates(py::module_& module, py::class_<Hand>& proxy, const Prose& prose) {
  py::class_<State>(module, "State")
      .def("__copy__", [](const py::object& self) { return self; })
      .def("__deepcopy__", [](const py::object& self, const py::object&) { return self; })
      .def("__repr__",
           [](const State& state) {
             if (!state.model) return Shown("State", "of ", state.bytes.size(), " bytes");
             return Shown("State", "of a tool at ", Row(state.proxy.step.X_WG.p.data(), 3), " m");
           })
      .def(py::pickle(&Pickle, &UnpickleState));
  proxy
      .def(
          "state", [](Hand& hand) { return StateOf(hand); }, prose("Proxy.state"))
      .def("set_state", &SetState, py::arg("state"), prose("Proxy.set_state"))
      .def("__copy__", &Copy)
      .def("__deepcopy__", [](Hand& hand, const py::object&) { return Copy(hand); })
      .def(py::pickle(
          [](Hand& hand) {
            const State state = StateOf(hand);
            py::object ask = py::none();
            double max_force_N = 0.0, max_torque_Nm = 0.0;
            std::uint64_t every = 1;
            if (hand.effect) {
              ask = hand.effect->ask;
              max_force_N = hand.effect->memory.held.max_force_N;
              max_torque_Nm = hand.effect->memory.held.max_torque_Nm;
              every = hand.effect->memory.held.every;
            }
            return py::make_tuple(hand.shared, state, ask, every, max_force_N, max_torque_Nm);
          },
          [](const py::tuple& stored) {
            if (stored.size() != 6) throw Error("pickle: the Proxy is damaged; store it again");
            const auto shared = stored[0].cast<Shared>();
            auto hand = std::make_unique<Hand>(shared, ProxyState{StepState(*shared.model), 0.0});
            if (const py::object ask = stored[2]; !ask.is_none()) {
              hand->effect = SlowEffect{ask,
                                        {ToHeld(ask, 1000.0 / stored[3].cast<double>(),
                                                stored[4].cast<double>(), stored[5].cast<double>()),
                                         {}}};
            }
            SetState(*hand, stored[1].cast<const State&>());
            return hand;
          }));
}

}  // namespace palpate
