#ifndef PALPATE_DEVICE_H
#define PALPATE_DEVICE_H

/** @file
 * A driver of one's own for palpate-station: a shared object with the seven functions below, in C
 * or in whatever makes C functions, loaded by `palpate-station --device ./mine.so`.  It links
 * nothing of palpate's.
 *
 * Metres, newtons, newton metres, seconds; quaternions are w x y z.  Poses are of the handle in the
 * device's own frame; the wrench acts at the handle's origin, in the same frame.
 *
 * What a driver returns is checked, and what it is given has passed the station's limiter.  A
 * number other than 0, a pose that is none, a reading that does not come anew and a call that does
 * not return each take the force away, and it comes back by a ramp.  Only a crash takes the station
 * with it: the arm's own watchdog has to end the force then.
 *
 * Threads: open and close are the main thread's (close the loop's, where that hung to the end);
 * read, write and their last_error the loop's, a thousand times a second or more: they neither
 * allocate nor lock nor log, and what blocks has a thread of its own.  stop may come from any
 * thread, also while another call has not returned.  No exception may leave a function.
 */

#include <stdint.h>

#ifdef __cplusplus
#define PALPATE_DEVICE_API extern "C" __attribute__((visibility("default")))
#else
#define PALPATE_DEVICE_API __attribute__((visibility("default")))
#endif

/** Grows when this file changes.  A station takes drivers of every version up to its own. */
#define PALPATE_DEVICE_ABI 1

typedef struct palpate_device palpate_device; /**< the driver's own */

/** The data sheet.  The limiter takes its bounds from it, so every figure needs its source. */
typedef struct {
  char model[64];            /**< for people, ends in 0 */
  double max_force_N;        /**< peak, at the handle */
  double continuous_force_N; /**< what the motors stand for ever */
  double max_torque_Nm;      /**< 0: the device renders no torque */
  double continuous_torque_Nm;
  double workspace_m[3];        /**< size of the box that the handle reaches ... */
  double workspace_centre_m[3]; /**< ... about this point of the device's frame */
  double position_resolution_m;
  double rotation_resolution_rad;
  double thermal_time_s; /**< of the motors; 60 where the driver leaves it as it was given */
} palpate_device_info;

typedef struct {
  double position_m[3];
  double orientation_wxyz[4]; /**< of length 1; left as it was given: a handle that does not turn */
  uint64_t number;  /**< another one each time the arm itself has been read anew: the same for 10 ms
                       is an arm that is stuck */
  uint32_t buttons; /**< bit 0: the first, which lets forces out while it is held */
  double motor_temperature; /**< of the hottest motor, 0 cool to 1 its limit; left as it was given:
                               not known */
} palpate_device_reading;

/** Returns PALPATE_DEVICE_ABI. */
PALPATE_DEVICE_API uint32_t palpate_device_abi(void);
/** Finds the arm, renders no force, and fills in `info`.  NULL: failed, see last_error.
 * `name`: as after --device-name, "" where none is given.  `rate_Hz`: of read and write. */
PALPATE_DEVICE_API palpate_device* palpate_device_open(const char* name, double rate_Hz,
                                                       palpate_device_info* info);
/** 0: `reading` is filled in.  Else there is none, and the pose is held without force: a cable that
 * is out, an arm that has yet to be calibrated. */
PALPATE_DEVICE_API int palpate_device_read(palpate_device* device, palpate_device_reading* reading);
/** Commands the handle until the next write. */
PALPATE_DEVICE_API int palpate_device_write(palpate_device* device, const double force_N[3],
                                            const double torque_Nm[3]);
/** Takes all force off at once.  A write that has begun before gives none any more; one that begins
 * afterwards may. */
PALPATE_DEVICE_API int palpate_device_stop(palpate_device* device);
/** The last call, after a stop. */
PALPATE_DEVICE_API void palpate_device_close(palpate_device* device);
/** Why the last call of the same thread failed, and what to do: a sentence.  `device`: NULL where
 * open has failed. */
PALPATE_DEVICE_API const char* palpate_device_last_error(palpate_device* device);

#endif /* PALPATE_DEVICE_H */
