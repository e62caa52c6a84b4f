#ifndef PALPATE_EFFECT_H
#define PALPATE_EFFECT_H

/** @file
 * An added force: a shared object that defines palpate_the_effect, in C or a language that exports
 * C symbols.  A scene file names it in "effects".  It links against nothing of Palpate.
 *
 * Metres, newtons, newton metres, seconds; quaternions are w x y z; all in the scene's frame.  The
 * wrench acts on the hand, at the origin of the tool's frame where the hand holds it.
 *
 * The wrench must depend on the arguments of `step` only: no clock, no variable that outlives a
 * call, no sin, exp or pow, which differ between processors.  Then recordings replay bit for bit.
 * Keep what has to be remembered in `state`, which the host saves, copies and restores.  `step`
 * runs a thousand times a second: it must not allocate, lock or log.
 *
 * If `step` returns a number other than 0, throws, or gives a value that is not finite or is beyond
 * PALPATE_EFFECT_MOST, there is no force in that step, and the effect is off for the rest of the
 * session.  A crash ends the server too.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define PALPATE_EFFECT_API extern "C" __attribute__((visibility("default")))
#else
#define PALPATE_EFFECT_API extern __attribute__((visibility("default")))
#endif

/** Increases when this file changes.  A host accepts effects of every version up to its own. */
#define PALPATE_EFFECT_ABI 1
#define PALPATE_EFFECT_STATES 8
#define PALPATE_EFFECT_PARAMETERS 12
#define PALPATE_EFFECT_MOST 1e4 /**< of each number of a wrench [N, N m] */

typedef enum {
  PALPATE_EFFECT_NUMBER = 0, /**< 2.5 */
  PALPATE_EFFECT_POINT = 1,  /**< [x, y, z] */
  PALPATE_EFFECT_POINTS = 2, /**< [[x, y, z], ...], at least two */
  PALPATE_EFFECT_KIND_ANY_INT = 0x7fffffff
} palpate_effect_kind;

/** A parameter that a scene file gives, in the unit that ends its name. */
typedef struct {
  const char* name; /**< as in the scene file: "radius_mm" */
  palpate_effect_kind kind;
  double least, most; /**< of each number */
  double usual;       /**< of each number if the scene file does not give it; NAN: it must */
} palpate_effect_parameter;

typedef struct {
  const double* numbers; /**< one, or three for each point */
  size_t count;
} palpate_effect_values;

typedef struct {
  uint64_t cycle; /**< since the session began, from 0; one each millisecond */
  double position_m[3];
  double orientation_wxyz[4];
  double velocity_m_s[3]; /**< of that position, and of the rotation: smoothed over 4 ms */
  double turn_rad_s[3];
  double graphic_position_m[3]; /**< of the tool as drawn, which enters no object */
  double graphic_orientation_wxyz[4];
  const palpate_effect_values* values; /**< one for each parameter, in their order */
} palpate_effect_input;

typedef struct {
  double force_N[3]; /**< zero when step is called */
  double torque_Nm[3];
} palpate_effect_wrench;

typedef struct {
  uint32_t abi; /**< PALPATE_EFFECT_ABI */
  /** Not 0: along any closed path, the hand gets back no more energy than it has put in, which
   * `palpate-scene check` tests.  At an arm, a passive effect may use all of the arm's force and is
   * part of the limiter's energy balance; any other is limited to 1 N, like a guide. */
  int passive;
  palpate_effect_parameter parameters[PALPATE_EFFECT_PARAMETERS]; /**< to one without a name */
  /** @param state  zero in the session's first step; later as the last step left it. */
  int (*step)(const palpate_effect_input* input, double state[PALPATE_EFFECT_STATES],
              palpate_effect_wrench* wrench);
} palpate_effect;

PALPATE_EFFECT_API const palpate_effect palpate_the_effect;

#endif /* PALPATE_EFFECT_H */
