/* Dry friction in free space: a spring holds the hand at its last resting point, and the spring's
 * end slips once it pulls by more than force_N.  The position of the end is the state, which the
 * host keeps, so that a recording reproduces the same force. */
#include <math.h>
#include <palpate_effect.h>

enum { kForce, kStiffness };

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  if (in->cycle == 0) { /* state[0] to [2]: position of the spring's end */
    for (int i = 0; i < 3; ++i) state[i] = in->position_m[i];
  }
  const double most_m = in->values[kForce].numbers[0] / in->values[kStiffness].numbers[0];
  double way[3], square = 0.0;
  for (int i = 0; i < 3; ++i) {
    way[i] = state[i] - in->position_m[i];
    square += way[i] * way[i];
  }
  const double distance = sqrt(square), held = distance > most_m ? most_m / distance : 1.0;
  for (int i = 0; i < 3; ++i) {
    state[i] = in->position_m[i] + held * way[i];
    out->force_N[i] = in->values[kStiffness].numbers[0] * held * way[i];
  }
  return 0;
}

const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .passive = 1,
    .parameters = {[kForce] = {"force_N", PALPATE_EFFECT_NUMBER, 0.0, 20.0, 0.5},
                   [kStiffness] = {"stiffness_N_per_m", PALPATE_EFFECT_NUMBER, 10.0, 5000.0,
                                   1000.0}},
    .step = step};
