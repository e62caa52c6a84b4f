// An effect for tests that does everything an effect must not.
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <stdexcept>
#include <thread>

#include "scenes/effects/palpate_effect.h"

#ifndef WRONG_ABI
#define WRONG_ABI PALPATE_EFFECT_ABI
#endif

namespace {

enum Way {
  kRight,
  kNaN,
  kInfinite,
  kHuge,
  kFails,
  kThrows,
  kSwirls,
  kCrashes,
  kSlow,
  kClock,
  kRandom,
  kEnds
};

int Step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  const int way = static_cast<int>(in->values[0].numbers[0]);
  out->force_N[0] = 0.25;
  if (in->cycle < in->values[1].numbers[0]) return 0;
  state[0] += 1.0;
  switch (way) {
    case kNaN:
      out->torque_Nm[2] = std::numeric_limits<double>::quiet_NaN();
      break;
    case kInfinite:
      out->force_N[1] = std::numeric_limits<double>::infinity();
      break;
    case kHuge:
      out->force_N[1] = -1e30;
      break;
    case kFails:
      return 3;
    case kThrows:
      throw std::runtime_error("no");
    case kSwirls:
      out->force_N[0] = 10.0 * in->position_m[1];
      out->force_N[1] = -10.0 * in->position_m[0];
      break;
    case kCrashes:
      *static_cast<volatile int*>(nullptr) = 1;
      break;
    case kSlow:
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      break;
    case kClock:
      out->force_N[0] = 1e-9 * static_cast<double>(std::time(nullptr));
      break;
    case kRandom:
      out->force_N[0] = 1e-9 * std::rand();
      break;
    case kEnds:
      std::exit(0);
    default:
      break;
  }
  return 0;
}

}  // namespace

extern const palpate_effect palpate_the_effect = {
    .abi = WRONG_ABI,
    .passive = 1,
    .parameters = {{"way", PALPATE_EFFECT_NUMBER, 0.0, 11.0, 0.0},
                   {"from_cycle", PALPATE_EFFECT_NUMBER, 0.0, 1e6, 0.0}},
    .step = &Step};
