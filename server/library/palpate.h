#ifndef PALPATE_H
#define PALPATE_H

/** @file
 * Palpate for programs in C, and for everything that can load a C library: Unity, Unreal, Julia,
 * Python's ctypes.
 *
 * From meshes to a wrench: fill a scene, make a model from it, and a proxy for each hand.  Then
 * step the proxy once for each pose of the hand, for example a thousand times a second.
 *
 * Lengths are metres, forces newtons, torques newton metres; quaternions are w x y z.  A
 * palpate_pose is the pose of a body's frame in the world.  Functions that fail return NULL or a
 * number other than 0; palpate_last_error() then says why, and what to do.  Nothing throws across
 * this interface.  Data that is passed in is copied; no pointer is kept.
 *
 * Threads: a model never changes, and several threads may use it at once; only one thread at a time
 * may use a scene or a proxy.  Only palpate_proxy_step is real-time: it does not allocate, lock or
 * read a clock.
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

typedef struct palpate_scene palpate_scene; /**< tools and objects, being assembled */
typedef struct palpate_model
    palpate_model; /**< one tool of a scene against all objects; never changes */
typedef struct palpate_proxy palpate_proxy; /**< the tool that follows one hand */

typedef struct {
  double position_m[3];
  double orientation_wxyz[4]; /**< unit */
} palpate_pose;

typedef enum {
  PALPATE_SURFACE = 0,                 /**< meshes do not enter each other */
  PALPATE_SPHERES = 1,                 /**< leaves of sphere trees do not; objects may be soft */
  PALPATE_CONTACT_ANY_INT = 0x7fffffff /**< lets an invalid value be detected */
} palpate_contact;

typedef enum {
  PALPATE_OBJECT = 0,
  PALPATE_TOOL = 1,
  PALPATE_ROLE_ANY_INT = 0x7fffffff
} palpate_role;

/** Start from palpate_body_defaults(). */
typedef struct {
  palpate_pose pose; /**< of an object, in the world */
  size_t leaves; /**< number in its sphere tree; 0: 32 at most if its mesh is felt, else as many as
                    its shape needs */
  double static_friction;  /**< of an object */
  double dynamic_friction; /**< at most static_friction */
  double stiffness_N_m;    /**< of a leaf's contact, PALPATE_SPHERES; infinite: rigid */
} palpate_body;

typedef struct {
  double point_m[3]; /**< on the tool, in the world */
  double force_N[3]; /**< on the tool */
} palpate_point;

/** A parameter of a scene, by its name in scene files. */
typedef struct {
  const char* name;
  const char* unit; /**< empty: a count or a ratio */
  const char* what;
  double least, most;
  double usual; /**< value in a scene that does not set it */
  double value; /**< value in this scene; NAN if its materials differ */
} palpate_parameter;

#define PALPATE_POINTS 7

typedef struct {
  double force_N[3];   /**< on the hand, at the centroid of the tool */
  double torque_Nm[3]; /**< about that centroid */
  palpate_pose tool;   /**< the graphic tool: where to draw it */
  uint32_t faults;     /**< bits; 0: none; see palpate_fault_words */
  int32_t contacts;    /**< number of all; `points` of them are listed */
  int32_t points;
  palpate_point point[PALPATE_POINTS];
  const palpate_parameter* parameter; /**< used in the step; valid as long as the proxy */
  size_t parameters;                  /**< their number */
} palpate_report;

/** Returns the version, such as "0.1.0". */
PALPATE_API const char* palpate_version(void);
/** Returns the hash of the physics' sources: builds of one give the same bits for the same inputs.
 */
PALPATE_API const char* palpate_physics_revision(void);
/** Returns the message of the last failure in this thread, valid until the next one; never NULL. */
PALPATE_API const char* palpate_last_error(void);
/** Writes the faults in words into `text` of `size` bytes; returns the size that they need. */
PALPATE_API size_t palpate_fault_words(uint32_t faults, char* text, size_t size);

PALPATE_API palpate_body palpate_body_defaults(void);

/** Returns an empty scene; NULL if out of memory. */
PALPATE_API palpate_scene* palpate_scene_new(palpate_contact contact);
/** Loads a scene of the catalogue by its name, such as "bunny-bunny", or from a file: .json,
 * .palpate, or a mesh; gives the same bits as in the server.  The first time may take a minute or
 * two.  Assumptions about a mesh are printed on standard error. */
PALPATE_API palpate_scene* palpate_scene_load(const char* name_or_path);
/** The same, with sphere trees that follow their meshes to within `tolerance_um`, 0.1 to 1,000,000,
 * in place of the scene's leaves. */
PALPATE_API palpate_scene* palpate_scene_load_to(const char* name_or_path, double tolerance_um);
/** Writes a file *.palpate, which palpate_scene_load and palpate-server read. */
PALPATE_API int palpate_scene_save(const palpate_scene* scene, const char* file);
PALPATE_API void palpate_scene_free(palpate_scene* scene);
/** Returns the name of the tool with this index, from 0, valid until the scene changes; NULL if
 * there are no more.  `start`, if not NULL, receives the pose at which the scene places it. */
PALPATE_API const char* palpate_scene_tool(const palpate_scene* scene, size_t tool,
                                           palpate_pose* start);
/** Computes the hand's pose `seconds` into the script beside a loaded scene's file.  Returns the
 * script's length in seconds; 0 if there is no script. */
PALPATE_API double palpate_scene_hand(const palpate_scene* scene, double seconds,
                                      palpate_pose* hand);
/** Writes the parameter with this index, from 0.  Returns other than 0 if there are no more. */
PALPATE_API int palpate_scene_parameter(const palpate_scene* scene, size_t index,
                                        palpate_parameter* parameter);
/** Sets "stiffness_N_per_m", "separation_um", "friction" or another parameter, in its unit.  Call
 * it before a model is made. */
PALPATE_API int palpate_scene_set_parameter(palpate_scene* scene, const char* name, double value);
/** Adds a mesh.  `vertices_m`: x y z of each.  `triangles`: indices of three vertices each, from 0,
 * counter-clockwise seen from outside.  `body`: NULL for the defaults.  Takes seconds if the mesh
 * needs thousands of leaves. */
PALPATE_API int palpate_scene_add_mesh(palpate_scene* scene, palpate_role role, const char* name,
                                       const double* vertices_m, size_t vertex_count,
                                       const uint32_t* triangles, size_t triangle_count,
                                       const palpate_body* body);
PALPATE_API int palpate_scene_add_box(palpate_scene* scene, palpate_role role, const char* name,
                                      const double size_m[3], const palpate_body* body);
/** Adds an exact ball, of one leaf. */
PALPATE_API int palpate_scene_add_ball(palpate_scene* scene, palpate_role role, const char* name,
                                       double radius_m, const palpate_body* body);

/** Makes a model.  `tool`: index in the scene, from 0.  The scene may be freed afterwards. */
PALPATE_API palpate_model* palpate_model_new(const palpate_scene* scene, size_t tool);
PALPATE_API void palpate_model_free(palpate_model* model); /**< its proxies remain valid */

/** Makes a proxy, whose tool starts at the hand or at a free pose near it. */
PALPATE_API palpate_proxy* palpate_proxy_new(const palpate_model* model, const palpate_pose* hand);
PALPATE_API void palpate_proxy_free(palpate_proxy* proxy);
/** Returns the distance of the tool from the hand at the start [m].  Lead a hand that is deep
 * inside an object out before you apply forces. */
PALPATE_API double palpate_proxy_start_depth(const palpate_proxy* proxy);
/** Runs one cycle.  A pose that is not finite, or whose quaternion is not of length 1, sets a fault
 * and gives no force.  Returns report->faults. */
PALPATE_API uint32_t palpate_proxy_step(palpate_proxy* proxy, const palpate_pose* hand,
                                        palpate_report* report);

/** Writes the proxy's state into `bytes`, if `size` suffices, and returns the size that it needs; 0
 * if it cannot be stored (of a scene with solids that burs cut).  The bytes name the version and
 * the model. */
PALPATE_API size_t palpate_proxy_save(const palpate_proxy* proxy, void* bytes, size_t size);
/** Continues from a state that palpate_proxy_save wrote, of a proxy of the same model, also in
 * another process: the same poses then give the same bits.  Bytes that are damaged, or of another
 * version or model, are refused, and change nothing. */
PALPATE_API int palpate_proxy_restore(palpate_proxy* proxy, const void* bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif /* PALPATE_H */
