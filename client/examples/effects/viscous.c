/* A viscous field: it damps the hand's motion everywhere. */
#include <palpate_effect.h>

static int step(const palpate_effect_input* in, double* state, palpate_effect_wrench* out) {
  (void)state;
  for (int i = 0; i < 3; ++i) {
    out->force_N[i] = -in->values[0].numbers[0] * in->velocity_m_s[i];
    out->torque_Nm[i] = -in->values[1].numbers[0] * in->turn_rad_s[i];
  }
  return 0;
}

const palpate_effect palpate_the_effect = {
    .abi = PALPATE_EFFECT_ABI,
    .passive = 1,
    .parameters = {{"damping_N_s_per_m", PALPATE_EFFECT_NUMBER, 0.0, 20.0, 3.0},
                   {"damping_Nm_s_per_rad", PALPATE_EFFECT_NUMBER, 0.0, 0.02, 0.0}},
    .step = step};
