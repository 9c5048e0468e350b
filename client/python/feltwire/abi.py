"""The C interface of feltwire for ctypes. Written by make_bindings.py from api_table.py. Change the table."""
import ctypes

OK = 0  # It is done.
NOTHING = 1  # There is nothing yet, or nothing new.
ENDED = 2  # The hand's run has ended. fw_last_error() says why, if an error ended it.
ERROR_ARGUMENT = -1  # An argument is null, or an option is wrong. fw_last_error() names it and the remedy.
ERROR_REFUSED = -2  # The server refuses for good: the token, the scene, the device or a parameter.
ERROR_SERVER = -3  # The server is not reachable, not trusted, or full. Trying again may help.
ERROR_DEVICE = -4  # The device or a file cannot be opened.
ERROR_MEMORY = -5  # There is no memory for it.
ERROR_INTERNAL = -6  # Anything else. fw_last_error() has the text.


class HandOptions(ctypes.Structure):
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
        ("device", ctypes.c_char_p),  # as --device of feltwire-client: "simulated", "haply", "plugin:FILE.so". "caller": the program moves the hand and applies its force, by fw_hand_exchange()
        ("spec", ctypes.c_char_p),  # a built-in specification of the device, or FILE.json; null: the device's own
        ("duration", ctypes.c_double),  # [s] after which the run ends; 0: at fw_hand_close()
        ("stale_after", ctypes.c_double),  # [s] after which a hand of device "caller" that was not moved gets no force: 0.001 to less than a quarter of the hold time
        ("more", ctypes.POINTER(ctypes.c_char_p)),  # further options of feltwire-client: "--record", "a.mcap", ...; its --help-all lists them
        ("more_count", ctypes.c_uint32),  # number of these words
    ]


class Pose(ctypes.Structure):
    """A place of the tool, in the world frame."""
    _fields_ = [
        ("struct_size", ctypes.c_uint32),  # [bytes] of this struct, as the program knows it
        ("reserved", ctypes.c_uint32),  # 0
        ("position", ctypes.c_double * 3),  # [m]
        ("orientation", ctypes.c_double * 4),  # unit quaternion w, x, y, z; a device that senses no rotation ignores it
        ("buttons", ctypes.c_uint32),  # a bit each; the first is bit 0
        ("deadman", ctypes.c_uint32),  # 1: the person holds the enabling switch that lets the hand lead a robot
    ]


class Session(ctypes.Structure):
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


class Tick(ctypes.Structure):
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
    ]


# numpy.dtype() takes it.
POSE_DTYPE = {
    "names": ["struct_size", "reserved", "position", "orientation", "buttons", "deadman"],
    "formats": ["u4", "u4", ("f8", (3,)), ("f8", (4,)), "u4", "u4"],
    "offsets": [0, 4, 8, 32, 64, 68],
    "itemsize": 72,
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
    "names": ["struct_size", "reserved", "number", "time", "position", "orientation", "force", "torque", "reply_age", "balance", "account_cut", "zero_force_reason", "connected"],
    "formats": ["u4", "u4", "u8", "f8", ("f8", (3,)), ("f8", (4,)), ("f8", (3,)), ("f8", (3,)), "f8", "f8", "f8", "u4", "u4"],
    "offsets": [0, 4, 8, 16, 24, 48, 80, 104, 128, 136, 144, 152, 156],
    "itemsize": 160,
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
    return library
