/* A magnet: within its reach it pulls the tool's origin to the nearest point of a curve. */
#include <math.h>
#include <palpate_effect.h>

enum { kCurve, kReach, kForce };

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  (void)state;
  double best[3] = {0.0, 0.0, 0.0}, nearest = INFINITY;
  const palpate_effect_values* curve = &in->values[kCurve];
  for (size_t k = 3; k < curve->count; k += 3) {
    const double *a = curve->numbers + k - 3, *b = curve->numbers + k;
    double along = 0.0, length = 0.0, square = 0.0, way[3];
    for (int i = 0; i < 3; ++i) {
      along += (1e3 * in->position_m[i] - a[i]) * (b[i] - a[i]);
      length += (b[i] - a[i]) * (b[i] - a[i]);
    }
    const double share = length > 0.0 ? fmin(fmax(along / length, 0.0), 1.0) : 0.0;
    for (int i = 0; i < 3; ++i) {
      way[i] = 1e-3 * (a[i] + share * (b[i] - a[i])) - in->position_m[i];
      square += way[i] * way[i];
    }
    if (square < nearest) nearest = square;
    if (square == nearest) best[0] = way[0], best[1] = way[1], best[2] = way[2];
  }
  const double distance = sqrt(nearest), s = distance / (1e-3 * in->values[kReach].numbers[0]);
  if (s >= 1.0 || distance == 0.0) return 0;
  const double force = 4.0 * in->values[kForce].numbers[0] * s * (1.0 - s); /* most at half way */
  for (int i = 0; i < 3; ++i) out->force_N[i] = force / distance * best[i];
  return 0;
}
const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .parameters = {{"curve_mm", PALPATE_EFFECT_POINTS, -1e4, 1e4, NAN},
                   {"reach_mm", PALPATE_EFFECT_NUMBER, 0.1, 1000.0, 10.0},
                   {"force_N", PALPATE_EFFECT_NUMBER, 0.0, 20.0, 0.8}},
    .step = step};
