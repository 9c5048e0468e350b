/* The plugin ABI of feltwire for haptic devices, version 1. C99, no library needed.
 *
 * A plugin is a shared library that exports one function, feltwire_device(). feltwire-client loads it with
 *
 *     --device plugin:FILE.so        or        --device plugin:FILE.so:ARGUMENTS
 *
 * It is for devices whose maker's library is C++, or whose driver does not belong in feltwire. docs/devices.md explains what
 * the numbers mean and what the account behind them promises; examples/my_plugin.c is a whole plugin.
 *
 * Units are SI: m, rad, N, N m, kg, s. Vectors are in the world frame; forces and torques are those ON THE HAND. */
#ifndef FELTWIRE_DEVICE_V1_H
#define FELTWIRE_DEVICE_V1_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FELTWIRE_DEVICE_VERSION 1u

/* What the device is. The client zeroes it before open(), but for hand_force (10 N); a number that stays 0 is not known. Numbers
 * that the account counts on (damping, least_*) must be lower bounds: too large a number makes energy. */
typedef struct feltwire_spec_v1 {
  char name[64];              /* of the device, ends in a zero byte */
  const char* source;         /* where the numbers come from; null: they are assumptions, and the user is told so */
  int32_t translation_dof;    /* 2 (x, y) or 3 */
  int32_t rotation_sensed;    /* 0 or 3 */
  int32_t rotation_actuated;  /* 0 or 3 */
  double longest_tick;        /* [s] between two returns of wait(), guaranteed; 0: the client's timer sets the pace */
  double damping[3];          /* [N s/m] the device's own, along x, y, z */
  double rotational_damping;  /* [N m s/rad] */
  double apparent_mass;       /* [kg] */
  double coulomb_friction;    /* [N] */
  double position_resolution; /* [m] */
  double max_force;           /* [N] above 0 */
  double continuous_force;    /* [N] 0: as max_force */
  double max_torque;          /* [N m] */
  double workspace[3];        /* [m] full extent */
  double least_mass;          /* [kg] in every direction */
  double least_friction;      /* [N] */
  double hand_force;          /* [N] from outside, at most */
  double hand_speed;          /* [m/s] of the handle, at most */
  double rotational_resolution; /* [rad] */
  double least_inertia;       /* [kg m^2] about every axis */
  double hand_torque;         /* [N m] from outside, at most */
  int32_t late_ticks;         /* ticks from write() to the force on the hand, 0 to 4. Where write() leaves held_force alone, the
                                 client reckons with the force that it gave so many ticks before */
} feltwire_spec_v1;

/* What read() returns. */
enum {
  FELTWIRE_OK = 0,
  FELTWIRE_FAULT = 1, /* the position is not known: the force becomes zero */
  FELTWIRE_STALE = 2, /* nothing newer than the last reading: the force goes on being held, write() is not called */
  FELTWIRE_ENDED = 3  /* there will be no more readings: the run ends */
};

typedef struct feltwire_reading_v1 {
  double position[3];    /* [m] of the tool */
  double orientation[4]; /* w, x, y, z of a unit quaternion; the client begins with 1, 0, 0, 0 */
  int32_t tells_held;    /* not 0: the two below are the mean force and torque since the last reading, where the device
                            knows better than write() did */
  double held_force[3], held_torque[3];
  uint32_t buttons;      /* a bit each, the first is bit 0. The first lets the hand lead a robot (the deadman), the second
                            lifts the hand off the scene (the clutch) */
  int32_t has_lever;     /* not 0: the device has a lever for a robot's gripper, and the next is the wanted opening [m] */
  double lever;
} feltwire_reading_v1;

/* How the force follows a command within the told time. */
enum {
  FELTWIRE_LAG_DELAY = 0,  /* any response that has the whole command by then */
  FELTWIRE_LAG_FILTER = 1, /* a first-order lag with this time constant */
  FELTWIRE_LAG_MIXED = 2   /* a delay and a first-order lag after it, this long together */
};

/* The body that the positions of read() are measured at. The client's energy bounds hold at the motor. */
enum {
  FELTWIRE_ENCODER_MOTOR = 0,
  FELTWIRE_ENCODER_HANDLE = 1 /* behind the transmission: the client warns */
};

/* Functions may be added at the end. A plugin that was built against an older header is loaded as if they were null. */
typedef struct feltwire_device_v1 {
  uint32_t version; /* FELTWIRE_DEVICE_VERSION */
  uint32_t size;    /* sizeof(feltwire_device_v1) */

  /* Opens the device that `arguments` (never null) names. Returns what the other functions are given; or null, with the
   * reason in `error` (of error_size bytes, ends in a zero byte): what is wrong, and the remedy. May block. */
  void* (*open)(const char* arguments, feltwire_spec_v1* spec, char* error, size_t error_size);

  /* Waits for the device's tick until latest_ns (CLOCK_MONOTONIC) at most. Returns 1, or 0 where none came. It is called
   * where longest_tick is above 0, and may be null else. */
  int (*wait)(void* device, int64_t latest_ns);

  /* wait(), read() and write() are called by one thread, in this order, once a tick. read() and write() must not block,
   * allocate or throw. */
  int (*read)(void* device, feltwire_reading_v1* reading);

  /* Holds force [N] and torque [N m] on the hand until the next call. held_force and held_torque are the same when it is
   * called; write there what is really held where that is less, or still the one before. Returns 0; or not 0 where nothing
   * is held. */
  int (*write)(void* device, const double force[3], const double torque[3], double held_force[3], double held_torque[3]);

  /* Takes the force off for good. Any thread and any signal handler may call it, more than once, also while the functions
   * above run or hang. So it must be async-signal-safe: one system call, or a flag that a thread of the plugin acts on. */
  void (*release)(void* device);

  /* After all else; release() was called before. May block. */
  void (*close)(void* device);

  /* How late the motors follow a write(), beside late_ticks. Called once, after open(). Sets an upper bound in *seconds, 0
   * for none, and a FELTWIRE_LAG_... in *kind, which is FELTWIRE_LAG_DELAY when it is called. Returns 1; or 0 where it is
   * not known. May be null. Where nothing is told the client assumes a lag, says so, and gives less of stiff walls. */
  int (*actuation_lag)(void* device, double* seconds, int32_t* kind);

  /* What stands between motor and handle. Called once, after open(). Sets a lower bound in *stiffness [N/m], 0 for a rigid
   * one, and a FELTWIRE_ENCODER_... in *encoder_side, which is FELTWIRE_ENCODER_MOTOR when it is called. Returns 1; or 0
   * where it is not known. May be null. Where nothing is told the client assumes a soft one, and says so. No force depends
   * on it: the client says at the start how much of a wall the hand can feel behind it. */
  int (*transmission)(void* device, double* stiffness, int32_t* encoder_side);
} feltwire_device_v1;

/* The plugin's one exported function. What it returns must stay. */
const feltwire_device_v1* feltwire_device(void);

#ifdef __cplusplus
}
#endif

#endif /* FELTWIRE_DEVICE_V1_H */
