/* The C interface of feltwire, version 0. C99 and C++.
 *
 * Written by make_bindings.py from api_table.py. Change the table.
 * docs/c_api.md has a tutorial. Units are SI. Every struct begins with its size: call its fw_..._default() with sizeof, or set
 * struct_size. A function returns a result: below 0 an error, and fw_last_error() has its text. No C++ exception leaves it.
 * Threads: each function says which thread may call it. "One thread at a time": for each hand. */
#ifndef FELTWIRE_H
#define FELTWIRE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define FW_EXPORT __attribute__((visibility("default")))
#else
#define FW_EXPORT
#endif

/* Results. Their numbers never change. */
enum {
  FW_OK = 0, /* It is done. */
  FW_NOTHING = 1, /* There is nothing yet, or nothing new. */
  FW_ENDED = 2, /* The hand's run has ended. fw_last_error() says why, if an error ended it. */
  FW_ERROR_ARGUMENT = -1, /* An argument is null, or an option is wrong. fw_last_error() names it and the remedy. */
  FW_ERROR_REFUSED = -2, /* The server refuses for good: the token, the scene, the device or a parameter. */
  FW_ERROR_SERVER = -3, /* The server is not reachable, not trusted, or full. Trying again may help. */
  FW_ERROR_DEVICE = -4, /* The device or a file cannot be opened. */
  FW_ERROR_MEMORY = -5, /* There is no memory for it. */
  FW_ERROR_INTERNAL = -6  /* Anything else. fw_last_error() has the text. */
};

typedef struct fw_hand fw_hand;

/* How a hand joins a scene. A null text is not given. */
typedef struct fw_hand_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* server; /* HOST:PORT of the server's control port */
  const char* fingerprint; /* of the server's certificate; or: */
  const char* fingerprint_file; /* the file with it; or: */
  const char* ca_file; /* file (PEM) of the authorities to trust */
  const char* token_file; /* file with the client's token */
  const char* scene; /* name of the scene to join */
  const char* name; /* of this client, for the server's log */
  const char* device; /* as --device of feltwire-client: "simulated", "haply", "plugin:FILE.so". "caller": the program moves
     the hand and applies its force, by fw_hand_exchange() */
  const char* spec; /* a built-in specification of the device, or FILE.json; null: the device's own */
  double duration; /* [s] after which the run ends; 0: at fw_hand_close() */
  double stale_after; /* [s] after which a hand of device "caller" that was not moved gets no force: 0.001 to less than a
     quarter of the hold time */
  const char* const* more; /* further options of feltwire-client: "--record", "a.mcap", ...; its --help-all lists them */
  uint32_t more_count; /* number of these words */
} fw_hand_options;

/* A place of the tool, in the world frame. */
typedef struct fw_pose {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  double position[3]; /* [m] */
  double orientation[4]; /* unit quaternion w, x, y, z; a device that senses no rotation ignores it */
  uint32_t buttons; /* a bit each; the first is bit 0 */
  uint32_t deadman; /* 1: the person holds the enabling switch that lets the hand lead a robot */
} fw_pose;

/* What the server granted. */
typedef struct fw_session {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint64_t number; /* of the session at the server */
  double servo_period; /* [s] between two ticks */
  double hold_time; /* [s] a force is held without a newer command; it fades from half of it on */
  double stiffness; /* [N/m] of the stiffest surface of the scene; 0: not known */
  double start_position[3]; /* [m] a point on a surface, where a hand that does not know the scene should begin */
  double start_normal[3]; /* unit normal of the surface there */
} fw_session;

/* A tick of the servo. */
typedef struct fw_tick {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint64_t number; /* of the tick, from 1 */
  double time; /* [s] since the first tick */
  double position[3]; /* [m] of the tool, world frame */
  double orientation[4]; /* unit quaternion w, x, y, z */
  double force[3]; /* [N] on the hand from this tick on */
  double torque[3]; /* [N m] on the hand from this tick on */
  double reply_age; /* [s] age of the newest command of the scene; -1: there is none yet */
  double balance; /* [J] balance of the energy account; not a number: there is no account */
  double account_cut; /* share of the command that the account took off, 0 to 1 */
  uint32_t zero_force_reason; /* why the force is zero: fw_zero_force_text(); 0: it is not zero, or nothing is touched */
  uint32_t connected; /* 1: the session is alive; 0: it is lost, and the hand looks for it */
} fw_tick;

/* The version of the library: major * 65536 + minor * 256 + patch.
   Threads: any thread. */
FW_EXPORT uint32_t fw_version(void);

/* The text of the last error of the calling thread, in one line; empty: there was none.
   Threads: any thread. */
FW_EXPORT const char* fw_last_error(void);

/* What a result means, in one sentence.
   Threads: any thread. */
FW_EXPORT const char* fw_result_text(int32_t result);

/* Why there is no force: "the hand touches nothing"; empty: no such reason.
   Threads: any thread. */
FW_EXPORT const char* fw_zero_force_text(uint32_t reason);

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_hand_options_default(fw_hand_options* options, uint32_t struct_size);

/* The origin, not turned.
   Threads: any thread. */
FW_EXPORT void fw_pose_default(fw_pose* pose, uint32_t struct_size);

/* Joins a scene, and runs the hand's servo in a thread of its own, with the energy account and the limits of feltwire-
   client. Blocks until the server has answered, and a device may make it wait for a person (homing). The hand must be
   closed.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_open(const fw_hand_options* options, fw_hand** hand);

/* What the server granted when the hand joined.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_session(const fw_hand* hand, fw_session* session, uint32_t struct_size);

/* For a hand of device "caller": gives the pose, and returns the newest tick, whose force the program applies until its
   next call. The energy account reckons with that. FW_NOTHING: there was no tick yet, so apply no force. FW_ENDED: the run
   has ended; apply no force.
   Threads: one thread at a time, never waits. */
FW_EXPORT int32_t fw_hand_exchange(fw_hand* hand, const fw_pose* pose, fw_tick* tick, uint32_t struct_size);

/* The newest tick, to watch the hand. FW_NOTHING: there was none yet. Never apply its force: the account does not know of
   it.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_hand_latest(const fw_hand* hand, fw_tick* tick, uint32_t struct_size);

/* Takes the ticks since the last call, at most `most`. After 16384 ticks without a call the newest are lost; their numbers
   tell it.
   Threads: one thread at a time, never waits. */
FW_EXPORT int32_t fw_hand_ticks(fw_hand* hand, fw_tick* ticks, uint32_t struct_size, uint32_t most, uint32_t* count);

/* Takes the oldest message for people that was not taken yet: a warning, or a change by an admin. It is cut at `size`,
   with the zero byte. FW_NOTHING: there is none.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_message(fw_hand* hand, char* text, uint32_t size);

/* Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_wait(fw_hand* hand, double timeout);

/* Lets the force fade and ends the run. Does not wait.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_stop(fw_hand* hand);

/* Ends the run, waits for it, and frees the hand, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if
   an error had ended the run. Null is allowed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_hand_close(fw_hand* hand);

#ifdef __cplusplus
}
#endif

#endif
