/* A vibration along a direction, as a triangle wave: a library's sine differs between
 * processors. */
#include <math.h>
#include <palpate_effect.h>

enum { kAlong, kForce, kRate };

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  (void)state;
  const double* along = in->values[kAlong].numbers;
  const double length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
  if (length == 0.0) return 1; /* no direction */
  const double turns = 1e-3 * (double)in->cycle * in->values[kRate].numbers[0];
  const double wave = 4.0 * fabs(turns - floor(turns) - 0.5) - 1.0;
  for (int i = 0; i < 3; ++i) {
    out->force_N[i] = in->values[kForce].numbers[0] * wave * along[i] / length;
  }
  return 0;
}

const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .parameters = {[kAlong] = {"along", PALPATE_EFFECT_POINT, -1.0, 1.0, 1.0},
                   [kForce] = {"force_N", PALPATE_EFFECT_NUMBER, 0.0, 5.0, 0.3},
                   [kRate] = {"rate_Hz", PALPATE_EFFECT_NUMBER, 0.1, 400.0, 100.0}},
    .step = step};
