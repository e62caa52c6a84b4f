/* A forbidden region: a ball that pushes the tool's origin out, as a spring does. */
#include <math.h>
#include <palpate_effect.h>

enum { kCentre, kRadius, kStiffness };

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  (void)state;
  double way[3], square = 0.0;
  for (int i = 0; i < 3; ++i) {
    way[i] = in->position_m[i] - 1e-3 * in->values[kCentre].numbers[i];
    square += way[i] * way[i];
  }
  const double distance = sqrt(square);
  const double depth = 1e-3 * in->values[kRadius].numbers[0] - distance;
  if (depth <= 0.0 || distance == 0.0) return 0;
  const double force = in->values[kStiffness].numbers[0] * depth;
  for (int i = 0; i < 3; ++i) out->force_N[i] = force / distance * way[i];
  return 0;
}

const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .passive = 1,
    .parameters = {[kCentre] = {"centre_mm", PALPATE_EFFECT_POINT, -1e4, 1e4, 0.0},
                   [kRadius] = {"radius_mm", PALPATE_EFFECT_NUMBER, 0.1, 1e4, NAN},
                   [kStiffness] = {"stiffness_N_per_m", PALPATE_EFFECT_NUMBER, 0.0, 5000.0, 500.0}},
    .step = step};
