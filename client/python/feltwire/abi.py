"""The C interface of feltwire for ctypes. Written by make_bindings.py from api_table.py. Change the table."""
import ctypes

from .values import Struct

OK = 0  # It is done.
NOTHING = 1  # There is nothing yet, or nothing new.
ENDED = 2  # The hand's run, the observer or the follower has ended. fw_last_error() says why, if an error ended it.
ERROR_ARGUMENT = -1  # An argument is null, or an option is wrong. fw_last_error() names it and the remedy.
ERROR_REFUSED = -2  # The server refuses for good: the token, the scene, the device or a parameter.
ERROR_SERVER = -3  # The server is not reachable, not trusted, or full. Trying again may help.
ERROR_DEVICE = -4  # The device or a file cannot be opened.
ERROR_MEMORY = -5  # There is no memory for it.
ERROR_INTERNAL = -6  # Anything else. fw_last_error() has the text.


class HandOptions(Struct):
    """How a hand joins a scene. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("server", ctypes.c_char_p),  # HOST:PORT of the server's control port
        ("fingerprint", ctypes.c_char_p),  # of the server's certificate; or:
        ("fingerprint_file", ctypes.c_char_p),  # the file with it; or:
        ("ca_file", ctypes.c_char_p),  # file (PEM) of the authorities to trust
        ("token_file", ctypes.c_char_p),  # file with the client's token
        ("scene", ctypes.c_char_p),  # name of the scene to join
        ("name", ctypes.c_char_p),  # of this client, for the server's log
        ("device", ctypes.c_char_p),  # as --device of feltwire-client: "simulated", "haply", "plugin:FILE.so". "caller": the program moves the hand and applies its force, by fw_hand_exchange(). "stepped": it makes the ticks too, by fw_hand_step()
        ("spec", ctypes.c_char_p),  # a built-in specification of the device, or FILE.json; null: the device's own
        ("duration", ctypes.c_double),  # [s] after which the run ends; 0: at fw_hand_close()
        ("stale_after", ctypes.c_double),  # [s] after which a hand of device "caller" that was not moved gets no force: 0.001 to less than a quarter of the hold time
        ("more", ctypes.POINTER(ctypes.c_char_p)),  # further options of feltwire-client: "--record", "a.mcap", ...; its --help-all lists them
        ("more_count", ctypes.c_uint32),  # number of these words
    ]


class Pose(Struct):
    """A place of the tool, in the world frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("position", ctypes.c_double * 3),  # [m]
        ("orientation", ctypes.c_double * 4),  # unit quaternion w, x, y, z; a device that senses no rotation ignores it
        ("buttons", ctypes.c_uint32),  # a bit each; the first is bit 0
        ("deadman", ctypes.c_uint32),  # 1: the person holds the enabling switch that lets the hand lead a robot
        ("gripper", ctypes.c_double),  # [m] the wanted opening of the robot's gripper; below 0: the hand has no lever for it
    ]


class Session(Struct):
    """What the server granted."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("number", ctypes.c_uint64),  # of the session at the server
        ("servo_period", ctypes.c_double),  # [s] between two ticks
        ("hold_time", ctypes.c_double),  # [s] a force is held without a newer command; it fades from half of it on
        ("stiffness", ctypes.c_double),  # [N/m] of the stiffest surface of the scene; 0: not known
        ("start_position", ctypes.c_double * 3),  # [m] a point on a surface, where a hand that does not know the scene should begin
        ("start_normal", ctypes.c_double * 3),  # unit normal of the surface there
    ]


class Tick(Struct):
    """A tick of the servo."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("number", ctypes.c_uint64),  # of the tick, from 1
        ("time", ctypes.c_double),  # [s] since the first tick
        ("position", ctypes.c_double * 3),  # [m] of the tool, world frame
        ("orientation", ctypes.c_double * 4),  # unit quaternion w, x, y, z
        ("force", ctypes.c_double * 3),  # [N] on the hand from this tick on
        ("torque", ctypes.c_double * 3),  # [N m] on the hand from this tick on
        ("reply_age", ctypes.c_double),  # [s] age of the newest command of the scene; -1: there is none yet
        ("balance", ctypes.c_double),  # [J] balance of the energy account; not a number: there is no account
        ("account_cut", ctypes.c_double),  # share of the command that the account took off, 0 to 1
        ("zero_force_reason", ctypes.c_uint32),  # why the force is zero: fw_zero_force_text(); 0: it is not zero, or nothing is touched
        ("connected", ctypes.c_uint32),  # 1: the session is alive; 0: it is lost, and the hand looks for it
        ("scene_force", ctypes.c_double * 3),  # [N] of the newest command of the scene, on the hand: before the bound, the account and the limits
        ("lead_state", ctypes.c_uint32),  # of a hand that leads a robot: fw_lead_state_text(); 0: it leads none, or the robot is missing
    ]


class WorldOptions(Struct):
    """How a hand meets the physics of the program. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("name", ctypes.c_char_p),  # of this hand, for its recording
        ("device", ctypes.c_char_p),  # as in hand_options
        ("spec", ctypes.c_char_p),  # as in hand_options
        ("duration", ctypes.c_double),  # [s] after which the run ends; 0: at fw_hand_close()
        ("stale_after", ctypes.c_double),  # as in hand_options
        ("stiffness", ctypes.c_double),  # [N/m] above 0: of the stiffest surface that the hand will meet
        ("start_position", ctypes.c_double * 3),  # [m] a point on a surface, where a hand that does not know the scene begins
        ("start_normal", ctypes.c_double * 3),  # unit normal of the surface there
        ("more", ctypes.POINTER(ctypes.c_char_p)),  # as in hand_options
        ("more_count", ctypes.c_uint32),  # number of these words
    ]


class Patch(Struct):
    """A surface near the tool, described around its point nearest to the tool. World frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("point", ctypes.c_double * 3),  # [m] on the surface
        ("normal", ctypes.c_double * 3),  # unit, towards the free side
        ("stiffness", ctypes.c_double),  # [N/m] above 0
        ("curvature", ctypes.c_double),  # [1/m] 1 / radius of a ball felt from outside, below 0 from inside; 0: a plane
        ("axis", ctypes.c_double * 3),  # unit vector along which the surface is straight (a cylinder); zero: the same curve all ways
        ("velocity", ctypes.c_double * 3),  # [m/s] of the surface
        ("radius", ctypes.c_double),  # [m] within which the patch is right, from its point; 0: the reach
        ("damping", ctypes.c_double),  # [N s/m] along the normal
        ("static_friction", ctypes.c_double),  # coefficient, not below dynamic_friction
        ("dynamic_friction", ctypes.c_double),  # coefficient
        ("viscous_friction", ctypes.c_double),  # [N s/m] against sliding
        ("object", ctypes.c_uint32),  # a number of the program's own, below 65536: friction sticks to an object from one call to the next
    ]


class Wrench(Struct):
    """A force and a torque of the surroundings on the hand. World frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("time", ctypes.c_double),  # [s] fw_tick.time of the pose that it is for
        ("force", ctypes.c_double * 3),  # [N]
        ("torque", ctypes.c_double * 3),  # [N m]
        ("stiffness", ctypes.c_double),  # [N/m] of the force when the tool moves along it; 0: not known
    ]


class ObserverOptions(Struct):
    """How an observer joins a scene. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("server", ctypes.c_char_p),  # HOST:PORT of the server's control port
        ("fingerprint", ctypes.c_char_p),  # of the server's certificate; or:
        ("fingerprint_file", ctypes.c_char_p),  # the file with it; or:
        ("ca_file", ctypes.c_char_p),  # file (PEM) of the authorities to trust
        ("certificate_file", ctypes.c_char_p),  # file (PEM) of the client's certificate, for a server that asks for one
        ("key_file", ctypes.c_char_p),  # file (PEM) of the key of that certificate
        ("token_file", ctypes.c_char_p),  # file with the token; null: the environment variable FELTWIRE_TOKEN has it
        ("scene", ctypes.c_char_p),  # name of the scene to observe
        ("name", ctypes.c_char_p),  # of this observer, for the server's log
        ("period", ctypes.c_double),  # [s] between two views of the scene, 0.001 to 0.1. A view tells of 6 hands, the next one of the next 6
        ("patience", ctypes.c_double),  # [s] for which a lost session is looked for; 0: not at all
    ]


class SceneState(Struct):
    """What an observer sees."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("number", ctypes.c_uint64),  # of the state, from 1
        ("time", ctypes.c_double),  # [s] of its newest view, since the observer was opened
        ("age", ctypes.c_double),  # [s] since that view came
        ("hands", ctypes.c_uint32),  # number of hands that are seen
        ("bodies", ctypes.c_uint32),  # number of bodies that move
        ("connected", ctypes.c_uint32),  # 1: the session is alive; 0: it is lost and looked for, and nothing is seen
        ("left_out", ctypes.c_uint32),  # times that a hand or body had no room: an observer keeps 1024 hands and 4096 bodies
    ]


class SeenHand(Struct):
    """A hand in the scene, as its server tells. World frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("number", ctypes.c_uint32),  # of its session in the scene, from 1; never used again
        ("states", ctypes.c_uint32),  # a bit each, from bit 0: no sample has come yet, it is silent, touches nothing, touches, samples were lost, the server's bound reduced the command, it was too large for the device, the movement was refused, the scene recovers, the device holds less than was commanded, it moves a robot
        ("time", ctypes.c_double),  # [s] of the view that told of it, since the observer was opened
        ("position", ctypes.c_double * 3),  # [m] of the tool
        ("orientation", ctypes.c_double * 4),  # unit quaternion w, x, y, z
        ("force", ctypes.c_double * 3),  # [N] on the hand, that its device holds as its client reports
        ("commanded", ctypes.c_double * 3),  # [N] on the hand, that the scene commands
        ("proxy", ctypes.c_double * 3),  # [m] place of the tool if it could enter no surface
        ("depth", ctypes.c_double),  # [m] of the tool in the object in which it is deepest
        ("delivered", ctypes.c_double),  # [J] to the hand so far
        ("burned", ctypes.c_double),  # [J] lower bound of the energy that the device has burned so far
        ("balance", ctypes.c_double),  # [J] of the client's energy account; not a number: it told none
        ("round_trip", ctypes.c_double),  # [s] of the client's newest answer; not a number: it told none
        ("samples", ctypes.c_uint64),  # that the server has taken so far
        ("missed", ctypes.c_uint64),  # samples that were lost on the way so far
        ("tool", ctypes.c_uint32),  # its index among the tools of the scene
    ]


class SeenBody(Struct):
    """A body that moves. World frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("object", ctypes.c_uint32),  # its index in the scene
        ("time", ctypes.c_double),  # [s] of the view that told of it, since the observer was opened
        ("position", ctypes.c_double * 3),  # [m]
        ("orientation", ctypes.c_double * 4),  # unit quaternion w, x, y, z
    ]


class AdminOptions(Struct):
    """Which server an admin changes. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("server", ctypes.c_char_p),  # HOST:PORT of the server's control port
        ("fingerprint", ctypes.c_char_p),  # of the server's certificate; or:
        ("fingerprint_file", ctypes.c_char_p),  # the file with it; or:
        ("ca_file", ctypes.c_char_p),  # file (PEM) of the authorities to trust
        ("certificate_file", ctypes.c_char_p),  # file (PEM) of the client's certificate, for a server that asks for one
        ("key_file", ctypes.c_char_p),  # file (PEM) of the key of that certificate
        ("token_file", ctypes.c_char_p),  # file with the token; null: the environment variable FELTWIRE_TOKEN has it
    ]


class FollowerOptions(Struct):
    """A robot, and the seat of a scene that it takes. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("server", ctypes.c_char_p),  # HOST:PORT of the server's control port
        ("fingerprint", ctypes.c_char_p),  # of the server's certificate; or:
        ("fingerprint_file", ctypes.c_char_p),  # the file with it; or:
        ("ca_file", ctypes.c_char_p),  # file (PEM) of the authorities to trust
        ("certificate_file", ctypes.c_char_p),  # file (PEM) of the client's certificate, for a server that asks for one
        ("key_file", ctypes.c_char_p),  # file (PEM) of the key of that certificate
        ("token_file", ctypes.c_char_p),  # file with the token; null: the environment variable FELTWIRE_TOKEN has it
        ("scene", ctypes.c_char_p),  # name of the scene that has the robot's seat
        ("seat", ctypes.c_char_p),  # name of the seat; null: the only seat of the scene
        ("name", ctypes.c_char_p),  # of this client, for the server's log
        ("robot", ctypes.c_char_p),  # kind of the robot, for the server's log
        ("period", ctypes.c_double),  # [s] between two samples of the library's loop, 0.0001 to 0.05. The program's own loop may have another rate
        ("stiffness", ctypes.c_double),  # [N/m] above 0: of the robot's own impedance controller
        ("damping", ctypes.c_double),  # [N s/m] of that controller
        ("own_damping", ctypes.c_double),  # [N s/m] that the robot's body has for certain
        ("mass", ctypes.c_double),  # [kg] that shows at the tool; 0: not known
        ("wrench_noise", ctypes.c_double),  # [N] largest error of a measured force
        ("gripper_opening", ctypes.c_double),  # [m] largest opening of the gripper; 0: there is none
        ("speed", ctypes.c_double),  # [m/s] limit of the target
        ("acceleration", ctypes.c_double),  # [m/s^2] limit of the target
        ("jerk", ctypes.c_double),  # [m/s^3] limit of the target
        ("leash", ctypes.c_double),  # [N] largest force by which the target pulls the robot
        ("workspace_low", ctypes.c_double * 3),  # [m] low corner of a box that limits the target, beside the workspace of the seat
        ("workspace_high", ctypes.c_double * 3),  # [m] its high corner; both corners 0: there is no box
        ("duration", ctypes.c_double),  # [s] after which the run ends; 0: at fw_follower_stop()
        ("patience", ctypes.c_double),  # [s] for which a lost session is looked for; 0: not at all
        ("locked", ctypes.c_uint32),  # axes that stay as they are while a hand is engaged, a bit each, from bit 0: x, y, z, rotation
        ("estimates_force", ctypes.c_uint32),  # 1: robot_state.force is an estimate, and not measured
    ]


class RobotState(Struct):
    """A robot, as its program measures it. The robot's own world frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("position", ctypes.c_double * 3),  # [m] of the tool
        ("orientation", ctypes.c_double * 4),  # of the tool, unit quaternion w, x, y, z
        ("velocity", ctypes.c_double * 3),  # [m/s] of the tool
        ("turning", ctypes.c_double * 3),  # [rad/s] of the tool
        ("force", ctypes.c_double * 3),  # [N] of the environment on the tool, if has_force is 1
        ("torque", ctypes.c_double * 3),  # [N m] of the environment on the tool, about the tool
        ("commanded_position", ctypes.c_double * 3),  # [m] of the target that the robot's controller holds now
        ("commanded_orientation", ctypes.c_double * 4),  # of that target, unit quaternion w, x, y, z
        ("gripper", ctypes.c_double),  # [m] opening
        ("gripper_force", ctypes.c_double),  # [N] that the gripper holds with
        ("has_force", ctypes.c_uint32),  # 1: the force is known. A force that is not known is not zero
        ("condition", ctypes.c_uint32),  # 0: the robot is well; 1: a protective stop, or its people hold it; 2: it has a fault
    ]


class RobotTarget(Struct):
    """What a robot is to do. The robot's own world frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("number", ctypes.c_uint64),  # of the sample of the library's loop, from 1
        ("sample", ctypes.c_uint64),  # of the leading hand, counted from 1, from which the newest command comes; 0: none
        ("position", ctypes.c_double * 3),  # [m] target of the tool, for the robot's controller
        ("orientation", ctypes.c_double * 4),  # of the target, unit quaternion w, x, y, z
        ("gripper", ctypes.c_double),  # [m] wanted opening
        ("age", ctypes.c_double),  # [s] of the newest command; -1: there is none yet. Above 0.1 s the target stands still
        ("state", ctypes.c_uint32),  # of hand and robot in the newest command: fw_lead_state_text(). 2: a hand is engaged, and the target follows it
        ("connected", ctypes.c_uint32),  # 1: the session is alive; 0: it is lost and looked for, and the target stands still
    ]


class RecorderOptions(Struct):
    """Where a recording goes. A null text is not given."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("file", ctypes.c_char_p),  # FILE.mcap
        ("mebibytes", ctypes.c_double),  # [MiB] after which the next of several files begins, FILE-0001.mcap; 0: one file
        ("seconds", ctypes.c_double),  # [s] after which the next of several files begins; 0: one file
        ("replace", ctypes.c_uint32),  # 1: a file that is there is replaced; 0: it is an error
    ]


class RecordingState(Struct):
    """How far a recording is."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("ticks", ctypes.c_uint64),  # that are in it or wait to be written
        ("lost", ctypes.c_uint64),  # ticks that had no room, because the disk was too slow: 16384 wait at most
        ("failed", ctypes.c_uint32),  # 1: a file can be written no more; fw_recorder_close() says why
    ]


# numpy.dtype() takes it.
POSE_DTYPE = {
    "names": ["struct_size", "reserved", "position", "orientation", "buttons", "deadman", "gripper"],
    "formats": ["u4", "u4", ("f8", (3,)), ("f8", (4,)), "u4", "u4", "f8"],
    "offsets": [0, 4, 8, 32, 64, 68, 72],
    "itemsize": 80,
}


# numpy.dtype() takes it.
SESSION_DTYPE = {
    "names": ["struct_size", "reserved", "number", "servo_period", "hold_time", "stiffness", "start_position", "start_normal"],
    "formats": ["u4", "u4", "u8", "f8", "f8", "f8", ("f8", (3,)), ("f8", (3,))],
    "offsets": [0, 4, 8, 16, 24, 32, 40, 64],
    "itemsize": 88,
}


# numpy.dtype() takes it.
TICK_DTYPE = {
    "names": ["struct_size", "reserved", "number", "time", "position", "orientation", "force", "torque", "reply_age", "balance", "account_cut", "zero_force_reason", "connected", "scene_force", "lead_state"],
    "formats": ["u4", "u4", "u8", "f8", ("f8", (3,)), ("f8", (4,)), ("f8", (3,)), ("f8", (3,)), "f8", "f8", "f8", "u4", "u4", ("f8", (3,)), "u4"],
    "offsets": [0, 4, 8, 16, 24, 48, 80, 104, 128, 136, 144, 152, 156, 160, 184],
    "itemsize": 192,
}


# numpy.dtype() takes it.
PATCH_DTYPE = {
    "names": ["struct_size", "reserved", "point", "normal", "stiffness", "curvature", "axis", "velocity", "radius", "damping", "static_friction", "dynamic_friction", "viscous_friction", "object"],
    "formats": ["u4", "u4", ("f8", (3,)), ("f8", (3,)), "f8", "f8", ("f8", (3,)), ("f8", (3,)), "f8", "f8", "f8", "f8", "f8", "u4"],
    "offsets": [0, 4, 8, 32, 56, 64, 72, 96, 120, 128, 136, 144, 152, 160],
    "itemsize": 168,
}


# numpy.dtype() takes it.
WRENCH_DTYPE = {
    "names": ["struct_size", "reserved", "time", "force", "torque", "stiffness"],
    "formats": ["u4", "u4", "f8", ("f8", (3,)), ("f8", (3,)), "f8"],
    "offsets": [0, 4, 8, 16, 40, 64],
    "itemsize": 72,
}


# numpy.dtype() takes it.
SCENE_STATE_DTYPE = {
    "names": ["struct_size", "reserved", "number", "time", "age", "hands", "bodies", "connected", "left_out"],
    "formats": ["u4", "u4", "u8", "f8", "f8", "u4", "u4", "u4", "u4"],
    "offsets": [0, 4, 8, 16, 24, 32, 36, 40, 44],
    "itemsize": 48,
}


# numpy.dtype() takes it.
SEEN_HAND_DTYPE = {
    "names": ["struct_size", "reserved", "number", "states", "time", "position", "orientation", "force", "commanded", "proxy", "depth", "delivered", "burned", "balance", "round_trip", "samples", "missed", "tool"],
    "formats": ["u4", "u4", "u4", "u4", "f8", ("f8", (3,)), ("f8", (4,)), ("f8", (3,)), ("f8", (3,)), ("f8", (3,)), "f8", "f8", "f8", "f8", "f8", "u8", "u8", "u4"],
    "offsets": [0, 4, 8, 12, 16, 24, 48, 80, 104, 128, 152, 160, 168, 176, 184, 192, 200, 208],
    "itemsize": 216,
}


# numpy.dtype() takes it.
SEEN_BODY_DTYPE = {
    "names": ["struct_size", "reserved", "object", "time", "position", "orientation"],
    "formats": ["u4", "u4", "u4", "f8", ("f8", (3,)), ("f8", (4,))],
    "offsets": [0, 4, 8, 16, 24, 48],
    "itemsize": 80,
}


# numpy.dtype() takes it.
ROBOT_STATE_DTYPE = {
    "names": ["struct_size", "reserved", "position", "orientation", "velocity", "turning", "force", "torque", "commanded_position", "commanded_orientation", "gripper", "gripper_force", "has_force", "condition"],
    "formats": ["u4", "u4", ("f8", (3,)), ("f8", (4,)), ("f8", (3,)), ("f8", (3,)), ("f8", (3,)), ("f8", (3,)), ("f8", (3,)), ("f8", (4,)), "f8", "f8", "u4", "u4"],
    "offsets": [0, 4, 8, 32, 64, 88, 112, 136, 160, 184, 216, 224, 232, 236],
    "itemsize": 240,
}


# numpy.dtype() takes it.
ROBOT_TARGET_DTYPE = {
    "names": ["struct_size", "reserved", "number", "sample", "position", "orientation", "gripper", "age", "state", "connected"],
    "formats": ["u4", "u4", "u8", "u8", ("f8", (3,)), ("f8", (4,)), "f8", "f8", "u4", "u4"],
    "offsets": [0, 4, 8, 16, 24, 48, 80, 88, 96, 100],
    "itemsize": 104,
}


# numpy.dtype() takes it.
RECORDING_STATE_DTYPE = {
    "names": ["struct_size", "reserved", "ticks", "lost", "failed"],
    "formats": ["u4", "u4", "u8", "u8", "u4"],
    "offsets": [0, 4, 8, 16, 24],
    "itemsize": 32,
}


def declare(library):
    """Sets the types of all functions of a loaded library, and returns it."""
    library.fw_version.restype = ctypes.c_uint32
    library.fw_version.argtypes = []
    library.fw_last_error.restype = ctypes.c_char_p
    library.fw_last_error.argtypes = []
    library.fw_result_text.restype = ctypes.c_char_p
    library.fw_result_text.argtypes = [ctypes.c_int32]
    library.fw_zero_force_text.restype = ctypes.c_char_p
    library.fw_zero_force_text.argtypes = [ctypes.c_uint32]
    library.fw_hand_options_default.restype = None
    library.fw_hand_options_default.argtypes = [ctypes.POINTER(HandOptions), ctypes.c_uint32]
    library.fw_pose_default.restype = None
    library.fw_pose_default.argtypes = [ctypes.POINTER(Pose), ctypes.c_uint32]
    library.fw_hand_open.restype = ctypes.c_int32
    library.fw_hand_open.argtypes = [ctypes.POINTER(HandOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_hand_session.restype = ctypes.c_int32
    library.fw_hand_session.argtypes = [ctypes.c_void_p, ctypes.POINTER(Session), ctypes.c_uint32]
    library.fw_hand_exchange.restype = ctypes.c_int32
    library.fw_hand_exchange.argtypes = [ctypes.c_void_p, ctypes.POINTER(Pose), ctypes.POINTER(Tick), ctypes.c_uint32]
    library.fw_hand_step.restype = ctypes.c_int32
    library.fw_hand_step.argtypes = [ctypes.c_void_p, ctypes.POINTER(Pose), ctypes.POINTER(Tick), ctypes.c_uint32]
    library.fw_hand_latest.restype = ctypes.c_int32
    library.fw_hand_latest.argtypes = [ctypes.c_void_p, ctypes.POINTER(Tick), ctypes.c_uint32]
    library.fw_hand_ticks.restype = ctypes.c_int32
    library.fw_hand_ticks.argtypes = [ctypes.c_void_p, ctypes.POINTER(Tick), ctypes.c_uint32, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint32)]
    library.fw_hand_message.restype = ctypes.c_int32
    library.fw_hand_message.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint32]
    library.fw_hand_wait.restype = ctypes.c_int32
    library.fw_hand_wait.argtypes = [ctypes.c_void_p, ctypes.c_double]
    library.fw_hand_stop.restype = ctypes.c_int32
    library.fw_hand_stop.argtypes = [ctypes.c_void_p]
    library.fw_hand_close.restype = ctypes.c_int32
    library.fw_hand_close.argtypes = [ctypes.c_void_p]
    library.fw_world_options_default.restype = None
    library.fw_world_options_default.argtypes = [ctypes.POINTER(WorldOptions), ctypes.c_uint32]
    library.fw_patch_default.restype = None
    library.fw_patch_default.argtypes = [ctypes.POINTER(Patch), ctypes.c_uint32]
    library.fw_wrench_default.restype = None
    library.fw_wrench_default.argtypes = [ctypes.POINTER(Wrench), ctypes.c_uint32]
    library.fw_hand_open_world.restype = ctypes.c_int32
    library.fw_hand_open_world.argtypes = [ctypes.POINTER(WorldOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_hand_touch.restype = ctypes.c_int32
    library.fw_hand_touch.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.POINTER(Patch), ctypes.c_uint32, ctypes.c_uint32]
    library.fw_hand_push.restype = ctypes.c_int32
    library.fw_hand_push.argtypes = [ctypes.c_void_p, ctypes.POINTER(Wrench)]
    library.fw_observer_options_default.restype = None
    library.fw_observer_options_default.argtypes = [ctypes.POINTER(ObserverOptions), ctypes.c_uint32]
    library.fw_observer_open.restype = ctypes.c_int32
    library.fw_observer_open.argtypes = [ctypes.POINTER(ObserverOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_observer_latest.restype = ctypes.c_int32
    library.fw_observer_latest.argtypes = [ctypes.c_void_p, ctypes.POINTER(SceneState), ctypes.c_uint32]
    library.fw_observer_hands.restype = ctypes.c_int32
    library.fw_observer_hands.argtypes = [ctypes.c_void_p, ctypes.POINTER(SeenHand), ctypes.c_uint32, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint32)]
    library.fw_observer_bodies.restype = ctypes.c_int32
    library.fw_observer_bodies.argtypes = [ctypes.c_void_p, ctypes.POINTER(SeenBody), ctypes.c_uint32, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint32)]
    library.fw_observer_hand_name.restype = ctypes.c_int32
    library.fw_observer_hand_name.argtypes = [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_char_p, ctypes.c_uint32]
    library.fw_observer_message.restype = ctypes.c_int32
    library.fw_observer_message.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint32]
    library.fw_observer_wait.restype = ctypes.c_int32
    library.fw_observer_wait.argtypes = [ctypes.c_void_p, ctypes.c_uint64, ctypes.c_double]
    library.fw_observer_close.restype = ctypes.c_int32
    library.fw_observer_close.argtypes = [ctypes.c_void_p]
    library.fw_admin_options_default.restype = None
    library.fw_admin_options_default.argtypes = [ctypes.POINTER(AdminOptions), ctypes.c_uint32]
    library.fw_admin_open.restype = ctypes.c_int32
    library.fw_admin_open.argtypes = [ctypes.POINTER(AdminOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_admin_request.restype = ctypes.c_int32
    library.fw_admin_request.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_char_p), ctypes.c_uint32, ctypes.POINTER(ctypes.c_char_p)]
    library.fw_admin_close.restype = ctypes.c_int32
    library.fw_admin_close.argtypes = [ctypes.c_void_p]
    library.fw_lead_state_text.restype = ctypes.c_char_p
    library.fw_lead_state_text.argtypes = [ctypes.c_uint32]
    library.fw_follower_options_default.restype = None
    library.fw_follower_options_default.argtypes = [ctypes.POINTER(FollowerOptions), ctypes.c_uint32]
    library.fw_robot_state_default.restype = None
    library.fw_robot_state_default.argtypes = [ctypes.POINTER(RobotState), ctypes.c_uint32]
    library.fw_follower_open.restype = ctypes.c_int32
    library.fw_follower_open.argtypes = [ctypes.POINTER(FollowerOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_follower_exchange.restype = ctypes.c_int32
    library.fw_follower_exchange.argtypes = [ctypes.c_void_p, ctypes.POINTER(RobotState), ctypes.POINTER(RobotTarget), ctypes.c_uint32]
    library.fw_follower_latest.restype = ctypes.c_int32
    library.fw_follower_latest.argtypes = [ctypes.c_void_p, ctypes.POINTER(RobotTarget), ctypes.c_uint32]
    library.fw_follower_message.restype = ctypes.c_int32
    library.fw_follower_message.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_uint32]
    library.fw_follower_wait.restype = ctypes.c_int32
    library.fw_follower_wait.argtypes = [ctypes.c_void_p, ctypes.c_double]
    library.fw_follower_stop.restype = ctypes.c_int32
    library.fw_follower_stop.argtypes = [ctypes.c_void_p]
    library.fw_follower_close.restype = ctypes.c_int32
    library.fw_follower_close.argtypes = [ctypes.c_void_p]
    library.fw_recorder_options_default.restype = None
    library.fw_recorder_options_default.argtypes = [ctypes.POINTER(RecorderOptions), ctypes.c_uint32]
    library.fw_recorder_open.restype = ctypes.c_int32
    library.fw_recorder_open.argtypes = [ctypes.c_void_p, ctypes.POINTER(RecorderOptions), ctypes.POINTER(ctypes.c_void_p)]
    library.fw_recorder_mark.restype = ctypes.c_int32
    library.fw_recorder_mark.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
    library.fw_recorder_state.restype = ctypes.c_int32
    library.fw_recorder_state.argtypes = [ctypes.c_void_p, ctypes.POINTER(RecordingState), ctypes.c_uint32]
    library.fw_recorder_close.restype = ctypes.c_int32
    library.fw_recorder_close.argtypes = [ctypes.c_void_p]
    return library
