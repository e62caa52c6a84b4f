/* Your own driver, here for a virtual arm: a handle of 80 g with some friction, and a hand that
 * holds it by a spring and moves it up and down between 38 mm and 26 mm above the origin.
 *
 *   cmake -S own_arm -B /tmp/own_arm && cmake --build /tmp/own_arm
 *   palpate-doctor --device /tmp/own_arm/libvirtual_arm.so
 *   palpate-server cube &
 *   palpate-station --device /tmp/own_arm/libvirtual_arm.so --scene cube --id me --enable-forces
 *
 * In a driver for a real arm, read asks the arm for its pose, and write tells its motors. */
#include <math.h>
#include <palpate_device.h>
#include <stdatomic.h>
#include <string.h>

struct palpate_device {
  double tick_s, time_s;
  double position_m[3], velocity_m_s[3];
  double force_N[3];  /* of the motors */
  atomic_int stopped; /* set by any thread */
  uint64_t number;
};

static const double kMass_kg = 0.08, kDamping_N_s_m = 4.0;
static const double kHand_N_m = 400.0, kMiddle_m = 0.032, kSwing_m = 0.006, kPeriod_s = 4.0;

static palpate_device the_arm;
static const char* the_error = "";

uint32_t palpate_device_abi(void) {
  return PALPATE_DEVICE_ABI;
}

palpate_device* palpate_device_open(const char* name, double rate_Hz, palpate_device_info* info) {
  if (*name) {
    the_error = "there is one virtual arm alone: leave --device-name out";
    return NULL;
  }
  /* Figures of a desktop arm; use the data sheet of a real one. */
  strcpy(info->model, "virtual arm");
  info->max_force_N = 5.0;
  info->continuous_force_N = 1.5;
  info->workspace_m[0] = info->workspace_m[1] = info->workspace_m[2] = 0.2;
  info->position_resolution_m = 1e-5;
  info->rotation_resolution_rad = 1e-3;
  memset(&the_arm, 0, sizeof the_arm);
  the_arm.tick_s = 1.0 / rate_Hz;
  the_arm.position_m[1] = kMiddle_m + kSwing_m;
  return &the_arm;
}

/* A tick of the arm's own physics, in semi-implicit Euler steps. */
static void move(palpate_device* arm) {
  arm->time_s += arm->tick_s;
  const double hand_m[3] = {0.0, kMiddle_m + kSwing_m * cos(6.2832 * arm->time_s / kPeriod_s), 0.0};
  for (int i = 0; i < 3; ++i) {
    const double hand_N = kHand_N_m * (hand_m[i] - arm->position_m[i]);
    const double motors_N = atomic_load(&arm->stopped) ? 0.0 : arm->force_N[i];
    arm->velocity_m_s[i] +=
        arm->tick_s / kMass_kg * (hand_N + motors_N - kDamping_N_s_m * arm->velocity_m_s[i]);
    arm->position_m[i] += arm->tick_s * arm->velocity_m_s[i];
  }
}

int palpate_device_read(palpate_device* arm, palpate_device_reading* reading) {
  move(arm);
  memcpy(reading->position_m, arm->position_m, sizeof arm->position_m);
  reading->number = ++arm->number;
  return 0;
}

int palpate_device_write(palpate_device* arm, const double force_N[3], const double torque_Nm[3]) {
  (void)torque_Nm;
  atomic_store(&arm->stopped, 0);
  memcpy(arm->force_N, force_N, sizeof arm->force_N);
  return 0;
}

int palpate_device_stop(palpate_device* arm) {
  atomic_store(&arm->stopped, 1);
  return 0;
}

void palpate_device_close(palpate_device* arm) {
  (void)arm;
}

const char* palpate_device_last_error(palpate_device* arm) {
  (void)arm;
  return the_error;
}
