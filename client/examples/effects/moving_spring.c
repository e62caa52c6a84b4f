/* A spring to a target that moves to and fro between two points, as a guiding hand does. */
#include <math.h>
#include <palpate_effect.h>

enum { kFrom, kTo, kPeriod, kStiffness, kMost };

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  (void)state;
  const double turns = 1e-3 * (double)in->cycle / in->values[kPeriod].numbers[0];
  const double s = 1.0 - fabs(2.0 * (turns - floor(turns)) - 1.0); /* 0 to 1 and back */
  const double share = s * s * (3.0 - 2.0 * s);                    /* at rest where it turns */
  const double *from = in->values[kFrom].numbers, *to = in->values[kTo].numbers;
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double target_m = 1e-3 * (from[i] + share * (to[i] - from[i]));
    out->force_N[i] = in->values[kStiffness].numbers[0] * (target_m - in->position_m[i]);
    square += out->force_N[i] * out->force_N[i];
  }
  const double most = in->values[kMost].numbers[0];
  for (int i = 0; i < 3 && square > most * most; ++i) out->force_N[i] *= most / sqrt(square);
  return 0;
}

const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .parameters = {[kFrom] = {"from_mm", PALPATE_EFFECT_POINT, -1e4, 1e4, NAN},
                   [kTo] = {"to_mm", PALPATE_EFFECT_POINT, -1e4, 1e4, NAN},
                   [kPeriod] = {"period_s", PALPATE_EFFECT_NUMBER, 0.1, 1000.0, 4.0},
                   [kStiffness] = {"stiffness_N_per_m", PALPATE_EFFECT_NUMBER, 0.0, 2000.0, 100.0},
                   [kMost] = {"most_N", PALPATE_EFFECT_NUMBER, 0.0, 20.0, 0.8}},
    .step = step};
