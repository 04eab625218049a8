/* halfphysics: a body for SMPL-X motion, from C (C99) and from whatever calls C.
 *
 * A world, compiled in Python (halfphysics.compile_world, Simulator.save_world) and read here, is driven frame by frame:
 *
 *     hp_world *world = hp_world_open("world.hpw");       // NULL: hp_error() says why
 *     hp_reset(world, translation, rotations);            // people at a pose, objects at their start
 *     hp_step(world, translation, rotations, 1.0 / 30);   // towards a pose, as far as physics lets them
 *     hp_get_pose(world, 0, corrected, corrected_rotations);
 *     hp_world_free(world);
 *
 * Metres, kilograms, seconds; the world is z-up; quaternions are w, x, y, z; rotations are axis-angle vectors [rad] of
 * the 55 joints of SMPL-X, relative to their parents, the pelvis first. Poses of several people follow each other.
 * The numbers are, bit for bit, those of halfphysics.Simulator in Python on the same machine.
 *
 * Functions that can fail return an hp_status: HP_OK, which is 0, or what went wrong; hp_error() then has a sentence
 * about the last failure of the calling thread. A failed call changes nothing. A world is used by one thread at a
 * time; different worlds by different threads at once. Pointers to names live as long as their world. */
#ifndef HALFPHYSICS_H
#define HALFPHYSICS_H

#include <stddef.h>
#include <stdint.h>

#if defined(HALFPHYSICS_STATIC)
#define HP_API
#elif !defined(_WIN32)
#define HP_API __attribute__((visibility("default")))
#elif defined(HALFPHYSICS_BUILD)
#define HP_API __declspec(dllexport)
#else
#define HP_API __declspec(dllimport)
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define HP_JOINTS 55

typedef enum hp_status {
  HP_OK = 0,
  HP_BAD_ARGUMENT = 1, /* a null pointer, a number out of range or not finite */
  HP_BAD_FILE = 2,     /* no world file, a damaged one, or one of another version */
  HP_NO_SUCH_NAME = 3, /* nothing of that name or index, or nothing that can do it */
  HP_NOT_STARTED = 4,  /* hp_reset comes first */
  HP_BAD_STATE = 5,    /* a state of another world, or a damaged one */
  HP_NO_MEMORY = 6,
  HP_FAILED = 7 /* a defect of the library: please report what hp_error() says */
} hp_status;

typedef enum hp_kind { HP_STATIC = 0, HP_OBJECT = 1, HP_LINK = 2, HP_PERSON = 3 } hp_kind;

typedef struct hp_world hp_world;

/* One contact during the last frame. Where two people touch, each has a row of its own. */
typedef struct hp_contact {
  int32_t person;  /* index of the person, -1 where an object touches something that is no person */
  int32_t part;    /* joint index of the person's part, -1 for objects */
  int32_t subject; /* index into names of the object that plays the part's role, else -1 */
  int32_t other;   /* index into names of what was touched */
  int32_t other_part; /* joint index on the other, where that is a person, else -1 */
  int32_t reserved;   /* 0 */
  double position[3]; /* in the world [m] */
  double normal[3];   /* unit vector from the other into the part */
  double impulse[3];  /* on the part, summed over the frame [N s] */
  double force[3];    /* the same as a mean over the frame [N] */
} hp_contact;

/* ---- library ---------------------------------------------------------------------------------------------------- */

/* Version of the library, as of the Python package: "0.1.0". */
HP_API const char* hp_version(void);
/* The layout of world files that the library reads. */
HP_API int hp_world_file_version(void);
/* What went wrong last in this thread, in words; "" before anything did. Valid until the next call that fails. */
HP_API const char* hp_error(void);
/* "pelvis", "left_hip", ...; NULL: no such joint. */
HP_API const char* hp_joint_name(int joint);

/* ---- worlds ----------------------------------------------------------------------------------------------------- */

/* A world from the bytes of a world file, which are not needed any longer; NULL: hp_error() says why. */
HP_API hp_world* hp_world_load(const void* bytes, size_t size);
/* The same from a file; NULL: hp_error() says why. */
HP_API hp_world* hp_world_open(const char* path);
/* NULL is allowed. */
HP_API void hp_world_free(hp_world* world);

/* ---- what is in it ---------------------------------------------------------------------------------------------- */

HP_API int hp_person_count(const hp_world* world);
/* Names of all that contacts refer to: statics, objects, links of articulated objects, people, in this order. */
HP_API int hp_name_count(const hp_world* world);
HP_API const char* hp_name(const hp_world* world, int index); /* NULL: no such index */
HP_API int hp_find(const hp_world* world, const char* name);  /* its index, -1: there is none */
HP_API int hp_kind_of(const hp_world* world, int index);      /* an hp_kind, -1: no such index */
/* What moves: the 55 parts of each person ("person/left_hip"), then objects, then links. */
HP_API int hp_body_count(const hp_world* world);
HP_API const char* hp_body_name(const hp_world* world, int body); /* NULL: no such body */
/* Joints of articulated objects ("door/hinge"). */
HP_API int hp_joint_count(const hp_world* world);
HP_API const char* hp_hinge_name(const hp_world* world, int joint); /* NULL: no such joint */

/* ---- running ---------------------------------------------------------------------------------------------------- */

/* Put the people at a pose and objects at their start; everything else is forgotten, stiffness included.
 * translation: people x 3 [m]; rotations: people x 55 x 3 [rad]. */
HP_API hp_status hp_reset(hp_world* world, const double* translation, const double* rotations);
/* Drive the people towards a pose for one frame of dt [s]. Arrays as those of hp_reset. */
HP_API hp_status hp_step(hp_world* world, const double* translation, const double* rotations,
                         double dt);

/* ---- reading ---------------------------------------------------------------------------------------------------- */

/* The corrected pose of a person: translation (3) [m], rotations (55 x 3) [rad]. */
HP_API hp_status hp_get_pose(hp_world* world, int person, double* translation, double* rotations);
/* Position [m] and quaternion of every body (bodies x 7), in the order of hp_body_name: frames of the joints, origins
 * of objects and links. */
HP_API hp_status hp_get_bodies(hp_world* world, double* out);
/* Position (3) [m] and quaternion (4) of an object or a link. */
HP_API hp_status hp_get_object(hp_world* world, const char* name, double* position,
                               double* quaternion);
/* Velocity (3) [m/s] of an object's origin and angular velocity (3) [rad/s], in the world. */
HP_API hp_status hp_get_velocity(hp_world* world, const char* name, double* velocity,
                                 double* angular_velocity);
/* Value of a joint of an articulated object: 1 number [rad or m], 4 of a ball, 7 of a free joint. Returns how many
 * through `count`; `out` has room for 7. */
HP_API hp_status hp_get_joint(hp_world* world, int joint, double* out, int* count);
/* Contacts of the last frame: their number through `count`, the first `room` of them into `out`. */
HP_API hp_status hp_get_contacts(hp_world* world, hp_contact* out, size_t room, size_t* count);
/* Minimum distance of the people from static geometry [m]; infinite beyond what the settings ask for. */
HP_API hp_status hp_get_clearance(hp_world* world, double* out);
/* Time by which blocked steps of the last frame were shortened [s]. */
HP_API hp_status hp_get_lost_time(hp_world* world, double* out);

/* ---- changing --------------------------------------------------------------------------------------------------- */

/* Stiffness of a person's joints (55), from the next step on; person -1: of all. hp_reset goes back. */
HP_API hp_status hp_set_stiffness(hp_world* world, int person, const double* stiffness);
/* Mass of a free object [kg]; its inertia changes by the same factor. It stays after hp_reset. */
HP_API hp_status hp_set_mass(hp_world* world, const char* name, double mass);
HP_API hp_status hp_get_mass(hp_world* world, const char* name, double* mass);
/* Friction of an item, or of a person, with all others: of two, the smaller counts, but pairs that the scene has set
 * apart keep theirs. It stays after hp_reset. */
HP_API hp_status hp_set_friction(hp_world* world, const char* name, double friction);
/* Give an object a velocity; what is asleep wakes. angular_velocity NULL: as it is. */
HP_API hp_status hp_set_velocity(hp_world* world, const char* name, const double* velocity,
                                 const double* angular_velocity);
/* Push an object, now, by an impulse (3) [N s] at a point (3) of the world [m]; point NULL: the centre of mass. */
HP_API hp_status hp_apply_impulse(hp_world* world, const char* name, const double* impulse,
                                  const double* point);
/* The axes (3 x 3, by rows) in which a person's poses are given, seen from the world: x_world = A x_pose of the pelvis
 * at rest, as halfphysics.Pose.axes. The file has those of the simulator that wrote it, else the identity. */
HP_API hp_status hp_set_axes(hp_world* world, int person, const double* axes);

/* ---- states ----------------------------------------------------------------------------------------------------- */

/* Everything that the simulation remembers, to go on from later, bit for bit, in this world or another one of the same
 * file whose masses and frictions are the same. `size` gets the size in bytes; with `out` of at least that `room` it
 * is written, else (out NULL) only measured. */
HP_API hp_status hp_save(hp_world* world, void* out, size_t room, size_t* size);
HP_API hp_status hp_load(hp_world* world, const void* state, size_t size);

#ifdef __cplusplus
}
#endif

#endif
