#ifndef PALPATE_DEVICE_H
#define PALPATE_DEVICE_H

/** @file
 * The interface of a driver for palpate-station: a shared object with the seven functions below, in
 * C or in any language that exports C functions, loaded by `palpate-station --device ./mine.so`. It
 * links against nothing of Palpate.
 *
 * Metres, newtons, newton metres, seconds; quaternions are w x y z.  Poses are of the handle in the
 * device's own frame; the wrench acts at the handle's origin, in the same frame.
 *
 * What a driver returns is checked, and the forces that it is given have passed the station's
 * limiter.  A return value other than 0, an invalid pose, a reading that is not renewed and a call
 * that does not return each remove the force; it comes back by a ramp.  Only a crash ends the
 * station too: the arm's own watchdog has to end the force then.
 *
 * Threads: open and close are called by the main thread (close by the loop, if that hung until the
 * end); read, write and their last_error by the loop, a thousand times a second or more: they must
 * not allocate, lock or log, and what blocks needs a thread of its own.  stop may be called by any
 * thread, even while another call has not returned.  No exception may leave a function.
 */

#include <stdint.h>

#ifdef __cplusplus
#define PALPATE_DEVICE_API extern "C" __attribute__((visibility("default")))
#else
#define PALPATE_DEVICE_API __attribute__((visibility("default")))
#endif

/** Increases when this file changes.  A station accepts drivers of every version up to its own. */
#define PALPATE_DEVICE_ABI 1

typedef struct palpate_device palpate_device; /**< defined by the driver */

/** The data sheet.  The limiter takes its limits from it, so state the source of every value. */
typedef struct {
  char model[64];            /**< to be shown; ends in 0 */
  double max_force_N;        /**< peak, at the handle */
  double continuous_force_N; /**< that the motors can hold without end */
  double max_torque_Nm;      /**< 0: the device renders no torque */
  double continuous_torque_Nm;
  double workspace_m[3];        /**< size of the box that the handle can reach ... */
  double workspace_centre_m[3]; /**< ... around this point in the device's frame */
  double position_resolution_m;
  double rotation_resolution_rad;
  double thermal_time_s; /**< of the motors; 60 unless the driver sets it */
} palpate_device_info;

typedef struct {
  double position_m[3];
  double orientation_wxyz[4]; /**< of length 1; leave it as it is if the handle does not turn */
  uint64_t number; /**< a new one with each new reading of the arm; if it is the same for 10 ms, the
                      arm counts as stuck */
  uint32_t buttons;         /**< bit 0: the first, which enables forces while it is held */
  double motor_temperature; /**< of the hottest motor, from 0, cool, to 1, its limit (above counts
                               as 1); leave it as it is if it is not known */
} palpate_device_reading;

/** Returns PALPATE_DEVICE_ABI. */
PALPATE_DEVICE_API uint32_t palpate_device_abi(void);
/** Finds the arm, renders no force, and fills in `info`.  NULL: failed, see last_error.
 * `name`: the argument of --device-name, or "".  `rate_Hz`: of read and write. */
PALPATE_DEVICE_API palpate_device* palpate_device_open(const char* name, double rate_Hz,
                                                       palpate_device_info* info);
/** 0: `reading` is filled in.  Else there is no reading, for example because a cable is out or the
 * arm is not calibrated, and the last pose is kept without force. */
PALPATE_DEVICE_API int palpate_device_read(palpate_device* device, palpate_device_reading* reading);
/** Commands the handle until the next write. */
PALPATE_DEVICE_API int palpate_device_write(palpate_device* device, const double force_N[3],
                                            const double torque_Nm[3]);
/** Removes all force at once.  A write that has already begun no longer gives any; one that begins
 * afterwards may. */
PALPATE_DEVICE_API int palpate_device_stop(palpate_device* device);
/** The last call, after a stop. */
PALPATE_DEVICE_API void palpate_device_close(palpate_device* device);
/** A sentence that says why the last call of the same thread failed, and what to do.  `device`:
 * NULL if open has failed. */
PALPATE_DEVICE_API const char* palpate_device_last_error(palpate_device* device);

#endif /* PALPATE_DEVICE_H */
