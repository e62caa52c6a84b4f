#ifndef PALPATE_EFFECT_H
#define PALPATE_EFFECT_H

/** @file
 * A force of one's own: a shared object that defines palpate_the_effect, in C or in whatever makes
 * C symbols, and that a scene file names among its "effects".  It links nothing of palpate's.
 *
 * Metres, newtons, newton metres, seconds; quaternions are w x y z; all in the scene's frame.  The
 * wrench acts on the hand, at the origin of the tool's frame where the hand holds it.
 *
 * The wrench follows from what `step` is given, and from nothing else: no clock, no variable that
 * outlives a call, no sin, exp or pow, which differ between processors.  Then recordings replay
 * bit for bit.  What is to be remembered is in `state`, which the host keeps, copies, and puts
 * back.  `step` runs a thousand times a second: it neither allocates nor locks nor logs.
 *
 * Where `step` returns a number other than 0, throws, or gives what is not finite or beyond
 * PALPATE_EFFECT_MOST, there is no force in that step, and none of this effect's in the session any
 * more.  A crash takes the server with it.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define PALPATE_EFFECT_API extern "C" __attribute__((visibility("default")))
#else
#define PALPATE_EFFECT_API extern __attribute__((visibility("default")))
#endif

/** Grows when this file changes.  Effects of every version up to the host's own are taken. */
#define PALPATE_EFFECT_ABI 1
#define PALPATE_EFFECT_STATES 8
#define PALPATE_EFFECT_PARAMETERS 12
#define PALPATE_EFFECT_MOST 1e4 /**< of each number of a wrench [N, N m] */

typedef enum {
  PALPATE_EFFECT_NUMBER = 0, /**< 2.5 */
  PALPATE_EFFECT_POINT = 1,  /**< [x, y, z] */
  PALPATE_EFFECT_POINTS = 2, /**< [[x, y, z], ...], two at least */
  PALPATE_EFFECT_KIND_ANY_INT = 0x7fffffff
} palpate_effect_kind;

/** What a scene file gives, in the unit that its name says. */
typedef struct {
  const char* name; /**< as in the scene file: "radius_mm" */
  palpate_effect_kind kind;
  double least, most; /**< of each number */
  double usual;       /**< of each number where the scene file says nothing; NAN: it has to */
} palpate_effect_parameter;

typedef struct {
  const double* numbers; /**< one, or three of each point */
  size_t count;
} palpate_effect_values;

typedef struct {
  uint64_t cycle; /**< since the session began, from 0: a millisecond each */
  double position_m[3];
  double orientation_wxyz[4];
  double velocity_m_s[3]; /**< of that position, and of the rotation: smoothed over 4 ms */
  double turn_rad_s[3];
  double graphic_position_m[3]; /**< of the tool that is drawn, which enters no object */
  double graphic_orientation_wxyz[4];
  const palpate_effect_values* values; /**< of each parameter, in their order */
} palpate_effect_input;

typedef struct {
  double force_N[3]; /**< zero as they are given */
  double torque_Nm[3];
} palpate_effect_wrench;

typedef struct {
  uint32_t abi; /**< PALPATE_EFFECT_ABI */
  /** Not 0: along whatever closed path, the hand gets no more than it has put in.  `palpate-scene
   * check` holds it to that.  At an arm, what is passive may take all of the arm's force and stands
   * in the limiter's account of energy; what is not is bounded as a guide is, to 1 N. */
  int passive;
  palpate_effect_parameter parameters[PALPATE_EFFECT_PARAMETERS]; /**< up to one without a name */
  /** @param state  zero in the session's first step; then as this left it. */
  int (*step)(const palpate_effect_input* input, double state[PALPATE_EFFECT_STATES],
              palpate_effect_wrench* wrench);
} palpate_effect;

PALPATE_EFFECT_API const palpate_effect palpate_the_effect;

#endif /* PALPATE_EFFECT_H */
