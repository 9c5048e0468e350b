/* The plugin ABI of feltwire for bounding laws, version 1. C99, no library needed.
 *
 * A law of your own is a shared library that exports one function, feltwire_law(). feltwire-lab loads it with
 *
 *     feltwire-lab compare --law FILE.so        and        feltwire-lab extremes --law FILE.so
 *
 * docs/own_bounding_law.md is the tutorial; examples/my_law.c is a whole law.
 *
 * Units are SI: m, rad, N, N m, s. Vectors are in the world frame; forces and torques are those ON THE HAND. */
#ifndef FELTWIRE_LAW_V1_H
#define FELTWIRE_LAW_V1_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FELTWIRE_LAW_VERSION 1u
#define FELTWIRE_LAW_LARGEST_STATE 1024u /* [bytes] */

/* The energy that the law promises never to make; the laboratory judges the law by it. */
enum {
  FELTWIRE_PROMISE_NONE = 0,            /* nothing: the force is finite and within the limit */
  FELTWIRE_PROMISE_PORT = 1,            /* the hand never gets more than the device burned, and the rest pays for the force */
  FELTWIRE_PROMISE_PORT_BY_AXIS = 2,    /* the same on each axis by itself */
  FELTWIRE_PROMISE_OWN_SUM_BY_AXIS = 4, /* the sum of F(n).dx(n) stays positive on each axis, F(n) = -f(n) */
  FELTWIRE_PROMISE_OWN_SUM = 5          /* the same over all axes, torque included */
};

/* Faults of a session in which the law keeps its promise. */
enum {
  FELTWIRE_KEPT_OVERLONG_HOLDS = 1, /* a force is held for longer than the period, or although it was not rendered */
  FELTWIRE_KEPT_REDUCTIONS = 2,     /* less is held than was rendered: a limit, a fade */
  FELTWIRE_KEPT_UNKNOWN_INPUTS = 4, /* a movement or a command was not a number */
  FELTWIRE_KEPT_ALL = 7
};

/* The device and its loop. */
typedef struct feltwire_law_device_v1 {
  double period;                /* T [s] for which a force is held, at least */
  double lag;                   /* [s] by which the motor follows its command, at most */
  double damping[9];            /* B [N s/m] of the device, by rows */
  double rotational_damping[9]; /* [N m s/rad] */
  double least_damping;         /* [N s/m] in the direction that is damped least; may be 0 */
  double least_rotational_damping; /* [N m s/rad] */
  double max_force;             /* [N] infinite: no limit */
  double max_torque;            /* [N m] */
  int32_t rotation;             /* not 0: there is torque; 0: rotation and torque are zero */
  int32_t reserved;
} feltwire_law_device_v1;

typedef struct feltwire_law_force_v1 {
  double elastic[3];    /* [N] of the surfaces */
  double frictional[3]; /* [N] all else: friction, damping. The whole force is the sum */
  double torque[3];     /* [N m] */
} feltwire_law_force_v1;

/* The movement while the last force was held, and the scene's command for the next. */
typedef struct feltwire_law_step_v1 {
  double displacement[3]; /* [m] of the device since the last step */
  double rotation[3];     /* [rad] rotation vector since the last step */
  double hold_time;       /* [s] for which the last force was held, at least the period */
  feltwire_law_force_v1 command;
  int32_t local;    /* not 0: the command was made at the device's position of now */
  int32_t reserved;
} feltwire_law_step_v1;

/* Functions may be added at the end. The memory `state` has state_size bytes, aligned to 16, and may be copied byte by byte: it has
 * numbers, and no pointer that owns something. Several threads call the functions, each with another state. */
typedef struct feltwire_law_v1 {
  uint32_t version; /* FELTWIRE_LAW_VERSION */
  uint32_t size;    /* sizeof(feltwire_law_v1) */

  const char* name;      /* in tables and --methods: a to z, 0 to 9 and _; no law of feltwire has it */
  const char* summary;   /* a line about it; null: none */
  int32_t promise;       /* FELTWIRE_PROMISE_... */
  int32_t kept_despite;  /* FELTWIRE_KEPT_..., added up */
  int32_t admits_reduction; /* not 0: a force that the law passed may be reduced further, if set_held() is told */
  uint32_t state_size;   /* [bytes] at most FELTWIRE_LAW_LARGEST_STATE */

  /* Begins a run. `state` is zeroed. Returns 0; or not 0 where the law cannot keep its promise with this device. */
  int32_t (*reset)(void* state, const feltwire_law_device_v1* device);
  /* Writes the force for the hand, finite numbers, which counts as held. It must not block or throw. */
  void (*step)(void* state, const feltwire_law_step_v1* step, feltwire_law_force_v1* rendered);
  /* Another force was held than step() returned: after a limit, a fade or a skipped write. */
  void (*set_held)(void* state, const feltwire_law_force_v1* held);
} feltwire_law_v1;

/* The one exported function. What it returns must stay. */
const feltwire_law_v1* feltwire_law(void);

#ifdef __cplusplus
}
#endif

#endif /* FELTWIRE_LAW_V1_H */
