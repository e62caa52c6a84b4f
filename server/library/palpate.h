#ifndef PALPATE_H
#define PALPATE_H

/** @file
 * Palpate for programs in C, and all that can load a C library: Unity, Unreal, Julia, Python's
 * ctypes.
 *
 * From meshes to a wrench: fill a scene, make a model of it, and a proxy for each hand; then step
 * the proxy once for each pose of the hand, a thousand times a second, say.
 *
 * Lengths are metres, forces newtons, torques newton metres; quaternions are w x y z.  Poses are of
 * a body's frame in the world.  What can fail returns NULL or a number other than 0, and
 * palpate_last_error() says why, and what to do.  Nothing throws across this interface.  Every
 * pointer that is handed in is copied from, never kept.
 *
 * Threads: a model never changes, and may be used by all threads; a scene or a proxy by one at a
 * time. Real-time: palpate_proxy_step alone: it neither allocates nor locks nor asks a clock.
 */

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define PALPATE_API
#else
#define PALPATE_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct palpate_scene palpate_scene; /**< what is felt, while it is put together */
typedef struct palpate_model
    palpate_model; /**< one tool of it against all objects; never changes */
typedef struct palpate_proxy palpate_proxy; /**< the tool that follows one hand */

typedef struct {
  double position_m[3];
  double orientation_wxyz[4]; /**< unit */
} palpate_pose;

typedef enum {
  PALPATE_SURFACE = 0, /**< meshes do not enter each other */
  PALPATE_SPHERES = 1, /**< leaves of their sphere trees do not; objects may be soft */
  PALPATE_CONTACT_ANY_INT = 0x7fffffff /**< lets a wrong number be told */
} palpate_contact;

typedef enum {
  PALPATE_OBJECT = 0,
  PALPATE_TOOL = 1,
  PALPATE_ROLE_ANY_INT = 0x7fffffff
} palpate_role;

/** Start from palpate_body_defaults(). */
typedef struct {
  palpate_pose pose; /**< objects: where they stand */
  size_t leaves; /**< of its sphere tree; 0: a few where its mesh is felt, else as many as its shape
                    needs */
  double static_friction;  /**< objects */
  double dynamic_friction; /**< at most static_friction */
  double stiffness_N_m;    /**< of a leaf's contact, PALPATE_SPHERES; infinite: rigid */
} palpate_body;

typedef struct {
  double point_m[3]; /**< on the tool, in the world */
  double force_N[3]; /**< on the tool */
} palpate_point;

/** What may be varied of a scene, by its name in scene files. */
typedef struct {
  const char* name;
  const char* unit; /**< empty: a count or a ratio */
  const char* what;
  double least, most;
  double usual; /**< of a scene that does not say */
  double value; /**< of this scene; not a number where its materials differ */
} palpate_parameter;

#define PALPATE_POINTS 7

typedef struct {
  double force_N[3];   /**< on the hand, at the centroid of the tool */
  double torque_Nm[3]; /**< about it */
  palpate_pose tool;   /**< of the graphic tool: what should be drawn */
  uint32_t faults;     /**< 0: none; palpate_fault_words says what */
  int32_t contacts;    /**< all; of them `points` are listed */
  int32_t points;
  palpate_point point[PALPATE_POINTS];
  const palpate_parameter*
      parameter;     /**< what the step was made with, as long as its proxy lives */
  size_t parameters; /**< how many there are */
} palpate_report;

/** "0.1.0". */
PALPATE_API const char* palpate_version(void);
/** What went wrong last in this thread; valid until its next failure. Never NULL. */
PALPATE_API const char* palpate_last_error(void);
/** Faults in words, for people, into `text` of `size` bytes; returns how many it would take. */
PALPATE_API size_t palpate_fault_words(uint32_t faults, char* text, size_t size);

PALPATE_API palpate_body palpate_body_defaults(void);

/** NULL: there is no memory. */
PALPATE_API palpate_scene* palpate_scene_new(palpate_contact contact);
/** A scene of the catalogue by its name, as "bunny-bunny", or of a file: .json, .palpate, or a
 * mesh; as the server has it, bit for bit.  Takes a minute or two where it is read for the first
 * time. What was assumed of a mesh is said on standard error. */
PALPATE_API palpate_scene* palpate_scene_load(const char* name_or_path);
/** Into a file *.palpate, which palpate_scene_load and palpate-server read. */
PALPATE_API int palpate_scene_save(const palpate_scene* scene, const char* file);
PALPATE_API void palpate_scene_free(palpate_scene* scene);
/** The name of a tool, from 0, as long as the scene is not changed; NULL: there are no more.
 * `start`: NULL, or gets where the scene places it. */
PALPATE_API const char* palpate_scene_tool(const palpate_scene* scene, size_t tool,
                                           palpate_pose* start);
/** Where the hand is, `seconds` into the script that stands beside a loaded scene's file.  How many
 * seconds it has; 0: there is no script. */
PALPATE_API double palpate_scene_hand(const palpate_scene* scene, double seconds,
                                      palpate_pose* hand);
/** The parameter of that index, from 0.  Not 0: there are no more. */
PALPATE_API int palpate_scene_parameter(const palpate_scene* scene, size_t index,
                                        palpate_parameter* parameter);
/** As "stiffness_N_per_m", "separation_um" or "friction", in its unit; before a model is made. */
PALPATE_API int palpate_scene_set_parameter(palpate_scene* scene, const char* name, double value);
/** `vertices_m`: x y z of each.  `triangles`: three vertices each, from 0, counter-clockwise seen
 * from outside.  `body`: NULL: the defaults.  Takes seconds for a mesh that needs thousands of
 * leaves. */
PALPATE_API int palpate_scene_add_mesh(palpate_scene* scene, palpate_role role, const char* name,
                                       const double* vertices_m, size_t vertex_count,
                                       const uint32_t* triangles, size_t triangle_count,
                                       const palpate_body* body);
PALPATE_API int palpate_scene_add_box(palpate_scene* scene, palpate_role role, const char* name,
                                      const double size_m[3], const palpate_body* body);
/** Exact: one leaf. */
PALPATE_API int palpate_scene_add_ball(palpate_scene* scene, palpate_role role, const char* name,
                                       double radius_m, const palpate_body* body);

/** `tool`: index of the tool in the scene, from 0.  The scene may be freed afterwards. */
PALPATE_API palpate_model* palpate_model_new(const palpate_scene* scene, size_t tool);
PALPATE_API void palpate_model_free(palpate_model* model); /**< proxies of it live on */

/** The tool begins at the hand, or at a free pose near it. */
PALPATE_API palpate_proxy* palpate_proxy_new(const palpate_model* model, const palpate_pose* hand);
PALPATE_API void palpate_proxy_free(palpate_proxy* proxy);
/** How far the tool was from the hand at its start [m]: lead a hand that is deep inside an object
 * out before you give it forces. */
PALPATE_API double palpate_proxy_start_depth(const palpate_proxy* proxy);
/** One cycle.  A pose that is not finite, or whose quaternion is not of length 1, is a fault, and
 * gives no force.  Returns report->faults. */
PALPATE_API uint32_t palpate_proxy_step(palpate_proxy* proxy, const palpate_pose* hand,
                                        palpate_report* report);

#ifdef __cplusplus
}
#endif

#endif /* PALPATE_H */
