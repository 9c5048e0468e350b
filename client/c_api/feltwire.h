/* The C interface of feltwire, version 0. C99 and C++.
 *
 * Written by make_bindings.py from api_table.py. Change the table.
 * docs/c_api.md has a tutorial. Units are SI. Every struct begins with its size: call its fw_..._default() with sizeof, or set
 * struct_size. A function returns a result: below 0 an error, and fw_last_error() has its text. No C++ exception leaves it.
 * Texts are UTF-8 and end in a zero byte. A path, and a word that may be one, has the bytes of the file system.
 * Threads: each function says which thread may call it. "One thread at a time": for each handle. */
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
  FW_ENDED = 2, /* The hand's run, the observer or the follower has ended. fw_last_error() says why, if an error ended it. */
  FW_ERROR_ARGUMENT = -1, /* An argument is null, or an option is wrong. fw_last_error() names it and the remedy. */
  FW_ERROR_REFUSED = -2, /* The server refuses for good: the token, the scene, the device or a parameter. */
  FW_ERROR_SERVER = -3, /* The server is not reachable, not trusted, or full. Trying again may help. */
  FW_ERROR_DEVICE = -4, /* The device or a file cannot be opened. */
  FW_ERROR_MEMORY = -5, /* There is no memory for it. */
  FW_ERROR_INTERNAL = -6  /* Anything else. fw_last_error() has the text. */
};

typedef struct fw_hand fw_hand; /* A hand in a scene. */
typedef struct fw_observer fw_observer; /* An observer of a scene. */
typedef struct fw_admin fw_admin; /* An admin of a server. */
typedef struct fw_follower fw_follower; /* A robot that follows a hand. */
typedef struct fw_recorder fw_recorder; /* A recording of a hand. */

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
     the hand and applies its force, by fw_hand_exchange(). "stepped": it makes the ticks too, by
     fw_hand_step() */
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
  double gripper; /* [m] the wanted opening of the robot's gripper; below 0: the hand has no lever for it */
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
  double scene_force[3]; /* [N] of the newest command of the scene, on the hand: before the bound, the account and the limits */
  uint32_t lead_state; /* of a hand that leads a robot: fw_lead_state_text(); 0: it leads none, or the robot is missing */
} fw_tick;

/* How a hand meets the physics of the program. A null text is not given. */
typedef struct fw_world_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* name; /* of this hand, for its recording */
  const char* device; /* as in hand_options */
  const char* spec; /* as in hand_options */
  double duration; /* [s] after which the run ends; 0: at fw_hand_close() */
  double stale_after; /* as in hand_options */
  double stiffness; /* [N/m] above 0: of the stiffest surface that the hand will meet */
  double start_position[3]; /* [m] a point on a surface, where a hand that does not know the scene begins */
  double start_normal[3]; /* unit normal of the surface there */
  const char* const* more; /* as in hand_options */
  uint32_t more_count; /* number of these words */
} fw_world_options;

/* A surface near the tool, described around its point nearest to the tool. World frame. */
typedef struct fw_patch {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  double point[3]; /* [m] on the surface */
  double normal[3]; /* unit, towards the free side */
  double stiffness; /* [N/m] above 0 */
  double curvature; /* [1/m] 1 / radius of a ball felt from outside, below 0 from inside; 0: a plane */
  double axis[3]; /* unit vector along which the surface is straight (a cylinder); zero: the same curve all ways */
  double velocity[3]; /* [m/s] of the surface */
  double radius; /* [m] within which the patch is right, from its point; 0: the reach */
  double damping; /* [N s/m] along the normal */
  double static_friction; /* coefficient, not below dynamic_friction */
  double dynamic_friction; /* coefficient */
  double viscous_friction; /* [N s/m] against sliding */
  uint32_t object; /* a number of the program's own, below 65536: friction sticks to an object from one call to the next */
} fw_patch;

/* A force and a torque of the surroundings on the hand. World frame. */
typedef struct fw_wrench {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  double time; /* [s] fw_tick.time of the pose that it is for */
  double force[3]; /* [N] */
  double torque[3]; /* [N m] */
  double stiffness; /* [N/m] of the force when the tool moves along it; 0: not known */
} fw_wrench;

/* How an observer joins a scene. A null text is not given. */
typedef struct fw_observer_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* server; /* HOST:PORT of the server's control port */
  const char* fingerprint; /* of the server's certificate; or: */
  const char* fingerprint_file; /* the file with it; or: */
  const char* ca_file; /* file (PEM) of the authorities to trust */
  const char* certificate_file; /* file (PEM) of the client's certificate, for a server that asks for one */
  const char* key_file; /* file (PEM) of the key of that certificate */
  const char* token_file; /* file with the token; null: the environment variable FELTWIRE_TOKEN has it */
  const char* scene; /* name of the scene to observe */
  const char* name; /* of this observer, for the server's log */
  double period; /* [s] between two views of the scene, 0.001 to 0.1. A view tells of 6 hands, the next one of the next
     6 */
  double patience; /* [s] for which a lost session is looked for; 0: not at all */
} fw_observer_options;

/* What an observer sees. */
typedef struct fw_scene_state {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint64_t number; /* of the state, from 1 */
  double time; /* [s] of its newest view, since the observer was opened */
  double age; /* [s] since that view came */
  uint32_t hands; /* number of hands that are seen */
  uint32_t bodies; /* number of bodies that move */
  uint32_t connected; /* 1: the session is alive; 0: it is lost and looked for, and nothing is seen */
  uint32_t left_out; /* times that a hand or body had no room: an observer keeps 1024 hands and 4096 bodies */
} fw_scene_state;

/* A hand in the scene, as its server tells. World frame. */
typedef struct fw_seen_hand {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint32_t number; /* of its session in the scene, from 1; never used again */
  uint32_t states; /* a bit each, from bit 0: no sample has come yet, it is silent, touches nothing, touches, samples were
     lost, the server's bound reduced the command, it was too large for the device, the movement was
     refused, the scene recovers, the device holds less than was commanded, it moves a robot */
  double time; /* [s] of the view that told of it, since the observer was opened */
  double position[3]; /* [m] of the tool */
  double orientation[4]; /* unit quaternion w, x, y, z */
  double force[3]; /* [N] on the hand, that its device holds as its client reports */
  double commanded[3]; /* [N] on the hand, that the scene commands */
  double proxy[3]; /* [m] place of the tool if it could enter no surface */
  double depth; /* [m] of the tool in the object in which it is deepest */
  double delivered; /* [J] to the hand so far */
  double burned; /* [J] lower bound of the energy that the device has burned so far */
  double balance; /* [J] of the client's energy account; not a number: it told none */
  double round_trip; /* [s] of the client's newest answer; not a number: it told none */
  uint64_t samples; /* that the server has taken so far */
  uint64_t missed; /* samples that were lost on the way so far */
  uint32_t tool; /* its index among the tools of the scene */
} fw_seen_hand;

/* A body that moves. World frame. */
typedef struct fw_seen_body {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint32_t object; /* its index in the scene */
  double time; /* [s] of the view that told of it, since the observer was opened */
  double position[3]; /* [m] */
  double orientation[4]; /* unit quaternion w, x, y, z */
} fw_seen_body;

/* Which server an admin changes. A null text is not given. */
typedef struct fw_admin_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* server; /* HOST:PORT of the server's control port */
  const char* fingerprint; /* of the server's certificate; or: */
  const char* fingerprint_file; /* the file with it; or: */
  const char* ca_file; /* file (PEM) of the authorities to trust */
  const char* certificate_file; /* file (PEM) of the client's certificate, for a server that asks for one */
  const char* key_file; /* file (PEM) of the key of that certificate */
  const char* token_file; /* file with the token; null: the environment variable FELTWIRE_TOKEN has it */
} fw_admin_options;

/* A robot, and the seat of a scene that it takes. A null text is not given. */
typedef struct fw_follower_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* server; /* HOST:PORT of the server's control port */
  const char* fingerprint; /* of the server's certificate; or: */
  const char* fingerprint_file; /* the file with it; or: */
  const char* ca_file; /* file (PEM) of the authorities to trust */
  const char* certificate_file; /* file (PEM) of the client's certificate, for a server that asks for one */
  const char* key_file; /* file (PEM) of the key of that certificate */
  const char* token_file; /* file with the token; null: the environment variable FELTWIRE_TOKEN has it */
  const char* scene; /* name of the scene that has the robot's seat */
  const char* seat; /* name of the seat; null: the only seat of the scene */
  const char* name; /* of this client, for the server's log */
  const char* robot; /* kind of the robot, for the server's log */
  double period; /* [s] between two samples of the library's loop, 0.0001 to 0.05. The program's own loop may have
     another rate */
  double stiffness; /* [N/m] above 0: of the robot's own impedance controller */
  double damping; /* [N s/m] of that controller */
  double own_damping; /* [N s/m] that the robot's body has for certain */
  double mass; /* [kg] that shows at the tool; 0: not known */
  double wrench_noise; /* [N] largest error of a measured force */
  double gripper_opening; /* [m] largest opening of the gripper; 0: there is none */
  double speed; /* [m/s] limit of the target */
  double acceleration; /* [m/s^2] limit of the target */
  double jerk; /* [m/s^3] limit of the target */
  double leash; /* [N] largest force by which the target pulls the robot */
  double workspace_low[3]; /* [m] low corner of a box that limits the target, beside the workspace of the seat */
  double workspace_high[3]; /* [m] its high corner; both corners 0: there is no box */
  double duration; /* [s] after which the run ends; 0: at fw_follower_stop() */
  double patience; /* [s] for which a lost session is looked for; 0: not at all */
  uint32_t locked; /* axes that stay as they are while a hand is engaged, a bit each, from bit 0: x, y, z, rotation */
  uint32_t estimates_force; /* 1: robot_state.force is an estimate, and not measured */
} fw_follower_options;

/* A robot, as its program measures it. The robot's own world frame. */
typedef struct fw_robot_state {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  double position[3]; /* [m] of the tool */
  double orientation[4]; /* of the tool, unit quaternion w, x, y, z */
  double velocity[3]; /* [m/s] of the tool */
  double turning[3]; /* [rad/s] of the tool */
  double force[3]; /* [N] of the environment on the tool, if has_force is 1 */
  double torque[3]; /* [N m] of the environment on the tool, about the tool */
  double commanded_position[3]; /* [m] of the target that the robot's controller holds now */
  double commanded_orientation[4]; /* of that target, unit quaternion w, x, y, z */
  double gripper; /* [m] opening */
  double gripper_force; /* [N] that the gripper holds with */
  uint32_t has_force; /* 1: the force is known. A force that is not known is not zero */
  uint32_t condition; /* 0: the robot is well; 1: a protective stop, or its people hold it; 2: it has a fault */
} fw_robot_state;

/* What a robot is to do. The robot's own world frame. */
typedef struct fw_robot_target {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint64_t number; /* of the sample of the library's loop, from 1 */
  uint64_t sample; /* of the leading hand, counted from 1, from which the newest command comes; 0: none */
  double position[3]; /* [m] target of the tool, for the robot's controller */
  double orientation[4]; /* of the target, unit quaternion w, x, y, z */
  double gripper; /* [m] wanted opening */
  double age; /* [s] of the newest command; -1: there is none yet. Above 0.1 s the target stands still */
  uint32_t state; /* of hand and robot in the newest command: fw_lead_state_text(). 2: a hand is engaged, and the target
     follows it */
  uint32_t connected; /* 1: the session is alive; 0: it is lost and looked for, and the target stands still */
} fw_robot_target;

/* Where a recording goes. A null text is not given. */
typedef struct fw_recorder_options {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  const char* file; /* FILE.mcap */
  double mebibytes; /* [MiB] after which the next of several files begins, FILE-0001.mcap; 0: one file */
  double seconds; /* [s] after which the next of several files begins; 0: one file */
  uint32_t replace; /* 1: a file that is there is replaced; 0: it is an error */
} fw_recorder_options;

/* How far a recording is. */
typedef struct fw_recording_state {
  uint32_t struct_size; /* [bytes] of this struct, as the program knows it */
  uint32_t reserved; /* 0 */
  uint64_t ticks; /* that are in it or wait to be written */
  uint64_t lost; /* ticks that had no room, because the disk was too slow: 16384 wait at most */
  uint32_t failed; /* 1: a file can be written no more; fw_recorder_close() says why */
} fw_recording_state;

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

/* For a hand of device "stepped", of a program that has a loop of its own: makes a tick with this pose, and returns it.
   The program applies its force until its next call. It blocks until the servo has made the tick. Call it once in a period
   of the servo (--rate): a call that comes later is a late tick to the energy account, and one later than a quarter of the
   hold time takes the force off. FW_NOTHING: there was no tick within that time, so apply no force. FW_ENDED: the run has
   ended; apply no force.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_hand_step(fw_hand* hand, const fw_pose* pose, fw_tick* tick, uint32_t struct_size);

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

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_world_options_default(fw_world_options* options, uint32_t struct_size);

/* A plane of 1000 N/m through the origin, without friction.
   Threads: any thread. */
FW_EXPORT void fw_patch_default(fw_patch* patch, uint32_t struct_size);

/* No force.
   Threads: any thread. */
FW_EXPORT void fw_wrench_default(fw_wrench* wrench, uint32_t struct_size);

/* Opens a hand that meets the physics of the program in place of a server's scene. All functions of a hand work with it.
   The program calls fw_hand_touch() or fw_hand_push() 60 to 1000 times a second; if it stops, the force fades within the
   hold time.
   Threads: any thread. */
FW_EXPORT int32_t fw_hand_open_world(const fw_world_options* options, fw_hand** hand);

/* For a hand of fw_hand_open_world(): says which surfaces are within `reach` [m] of the tool, at most 3; 0: none is.
   `time` [s]: fw_tick.time of the position that the physics used. The hand feels them at its servo rate until the next
   call, within the hold time. FW_NOTHING: the hand does not take them, because there was no tick yet, `time` is older than
   the hold time or than that of the last call, or its servo stands still. FW_ENDED: the run has ended.
   Threads: one thread at a time, never waits. */
FW_EXPORT int32_t fw_hand_touch(fw_hand* hand, double time, double reach, const fw_patch* patches, uint32_t struct_size, uint32_t count);

/* The same, for physics that knows a force only. With a stiffness the hand feels the plane that has this force at that
   position. Without one it feels the force as it is, as far as its account pays for it. Prefer fw_hand_touch(): a patch is
   felt before it pushes.
   Threads: one thread at a time, never waits. */
FW_EXPORT int32_t fw_hand_push(fw_hand* hand, const fw_wrench* wrench);

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_observer_options_default(fw_observer_options* options, uint32_t struct_size);

/* Joins a scene as an observer: it has no hand, and sees all hands and moving bodies. Blocks until the server has
   answered. A thread of the library takes the views. The observer must be closed.
   Threads: any thread. */
FW_EXPORT int32_t fw_observer_open(const fw_observer_options* options, fw_observer** observer);

/* The newest state. FW_NOTHING: no view has come yet.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_observer_latest(const fw_observer* observer, fw_scene_state* state, uint32_t struct_size);

/* The hands of the newest state, by rising number, at most `most`. FW_NOTHING: no view has come yet.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_observer_hands(const fw_observer* observer, fw_seen_hand* hands, uint32_t struct_size, uint32_t most, uint32_t* count);

/* The moving bodies of the newest state, by rising object, at most `most`. FW_NOTHING: no view has come yet.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_observer_bodies(const fw_observer* observer, fw_seen_body* bodies, uint32_t struct_size, uint32_t most, uint32_t* count);

/* The name that the client of a hand gives itself. The library asks the server for it when a hand has come. It is cut at
   `size`, with the zero byte. FW_NOTHING: it is not known yet, or there is no such hand.
   Threads: any thread. */
FW_EXPORT int32_t fw_observer_hand_name(fw_observer* observer, uint32_t number, char* text, uint32_t size);

/* Takes the oldest message for people that was not taken yet: the session was lost, or is there again. It is cut at
   `size`, with the zero byte. FW_NOTHING: there is none.
   Threads: any thread. */
FW_EXPORT int32_t fw_observer_message(fw_observer* observer, char* text, uint32_t size);

/* Waits for a state with a greater number, at most `timeout` [s]. FW_OK: it is there; FW_NOTHING: not yet; FW_ENDED: there
   will be none, and fw_last_error() says why.
   Threads: any thread. */
FW_EXPORT int32_t fw_observer_wait(fw_observer* observer, uint64_t number, double timeout);

/* Leaves the scene and frees the observer, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an
   error had ended it. Null is allowed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_observer_close(fw_observer* observer);

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_admin_options_default(fw_admin_options* options, uint32_t struct_size);

/* Reads the credentials, and asks the server for its scenes, so that an address or a token that is wrong is known at once.
   Blocks. No connection stays open. The admin must be closed.
   Threads: any thread. */
FW_EXPORT int32_t fw_admin_open(const fw_admin_options* options, fw_admin** admin);

/* Runs a command with the words of `feltwire-client admin` (docs/admin.md): "sessions", or "evict", "3". Blocks until it
   is done. Sets `answer` to its answer as JSON, which is valid until the next call with this admin; null where the command
   failed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_admin_request(fw_admin* admin, const char* const* words, uint32_t count, const char** answer);

/* Frees the admin, which no other call may use meanwhile. Null is allowed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_admin_close(fw_admin* admin);

/* The name of the state between a hand and a robot, such as "engaged"; empty: there is no such state.
   Threads: any thread. */
FW_EXPORT const char* fw_lead_state_text(uint32_t state);

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_follower_options_default(fw_follower_options* options, uint32_t struct_size);

/* At the origin, not turned, at rest, well, its force not known.
   Threads: any thread. */
FW_EXPORT void fw_robot_state_default(fw_robot_state* state, uint32_t struct_size);

/* Takes a seat for a robot, and runs the follower's loop of feltwire-follower in a thread of its own. Blocks until the
   server has answered. The follower must be closed.
   Threads: any thread. */
FW_EXPORT int32_t fw_follower_open(const fw_follower_options* options, fw_follower** follower);

/* Gives the robot's newest state, and returns the newest target, which the robot's controller gets. Call it at the rate of
   the robot's own loop, 100 to 1000 Hz. A robot that was not heard of for 0.1 s, that is stopped or that has a fault is
   not led: its target is where it is told to be already. FW_NOTHING: there is no target yet, so the robot stays. FW_ENDED:
   the run has ended; the robot stays at this target.
   Threads: one thread at a time, never waits. */
FW_EXPORT int32_t fw_follower_exchange(fw_follower* follower, const fw_robot_state* state, fw_robot_target* target, uint32_t struct_size);

/* The newest target, to watch the robot. FW_NOTHING: there is none yet.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_follower_latest(const fw_follower* follower, fw_robot_target* target, uint32_t struct_size);

/* Takes the oldest message for people that was not taken yet: the seat was lost, or the robot has it again. It is cut at
   `size`, with the zero byte. FW_NOTHING: there is none.
   Threads: any thread. */
FW_EXPORT int32_t fw_follower_message(fw_follower* follower, char* text, uint32_t size);

/* Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet.
   Threads: any thread. */
FW_EXPORT int32_t fw_follower_wait(fw_follower* follower, double timeout);

/* Leaves the scene. The target brakes for 0.25 s, then the run ends. Does not wait: call fw_follower_exchange() until
   FW_ENDED.
   Threads: any thread. */
FW_EXPORT int32_t fw_follower_stop(fw_follower* follower);

/* Ends the run, waits for it, and frees the follower, which no other call may use meanwhile. FW_OK, or FW_ENDED with a
   text if an error had ended the run. Null is allowed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_follower_close(fw_follower* follower);

/* Fills in the usual options. Call it first, with sizeof.
   Threads: any thread. */
FW_EXPORT void fw_recorder_options_default(fw_recorder_options* options, uint32_t struct_size);

/* Records every tick of a hand from its next tick on, as --record of feltwire-client does. One recording of a hand at a
   time. A thread of the library writes. The recorder must be closed; the hand may be closed before.
   Threads: any thread. */
FW_EXPORT int32_t fw_recorder_open(fw_hand* hand, const fw_recorder_options* options, fw_recorder** recorder);

/* Writes a text at this moment into the recording: a metadata record `mark` with `text` and `time` [ns since 1970]. A text
   that is not UTF-8 is refused.
   Threads: any thread. */
FW_EXPORT int32_t fw_recorder_mark(fw_recorder* recorder, const char* text);

/* How far the recording is.
   Threads: any thread, never waits. */
FW_EXPORT int32_t fw_recorder_state(const fw_recorder* recorder, fw_recording_state* state, uint32_t struct_size);

/* Writes the rest, waits until it is on the disk, and frees the recorder, which no other call may use meanwhile. FW_OK, or
   FW_ERROR_DEVICE with a text: a file is not complete, or ticks were lost. Null is allowed.
   Threads: one thread at a time. */
FW_EXPORT int32_t fw_recorder_close(fw_recorder* recorder);

#ifdef __cplusplus
}
#endif

#endif
