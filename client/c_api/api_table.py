"""The C interface of feltwire: its result codes, structs and functions. make_bindings.py writes the bindings of each language from it.

A struct grows at its end only, and nothing in it is ever removed or changes its meaning: a program of last year and one of next year
both run with this library. Types: u32, u64, f64, text (a pointer to UTF-8 that ends in a zero byte), texts (a pointer to such pointers),
f64[N]. An argument may be text* too: the function sets the program's pointer to a text of the library.
"""

# (name, documentation) of what a program holds and cannot look into.
HANDLES = [
    ("hand", "A hand in a scene."),
    ("observer", "An observer of a scene."),
    ("admin", "An admin of a server."),
    ("follower", "A robot that follows a hand."),
    ("recorder", "A recording of a hand."),
]

RESULTS = [
    ("OK", 0, "It is done."),
    ("NOTHING", 1, "There is nothing yet, or nothing new."),
    ("ENDED", 2, "The hand's run, the observer or the follower has ended. fw_last_error() says why, if an error ended it."),
    ("ERROR_ARGUMENT", -1, "An argument is null, or an option is wrong. fw_last_error() names it and the remedy."),
    ("ERROR_REFUSED", -2, "The server refuses for good: the token, the scene, the device or a parameter."),
    ("ERROR_SERVER", -3, "The server is not reachable, not trusted, or full. Trying again may help."),
    ("ERROR_DEVICE", -4, "The device or a file cannot be opened."),
    ("ERROR_MEMORY", -5, "There is no memory for it."),
    ("ERROR_INTERNAL", -6, "Anything else. fw_last_error() has the text."),
]

# Fields of the options of all that joins a server.
ACCESS = [
    ("text", "server", "HOST:PORT of the server's control port"),
    ("text", "fingerprint", "of the server's certificate; or:"),
    ("text", "fingerprint_file", "the file with it; or:"),
    ("text", "ca_file", "file (PEM) of the authorities to trust"),
    ("text", "certificate_file", "file (PEM) of the client's certificate, for a server that asks for one"),
    ("text", "key_file", "file (PEM) of the key of that certificate"),
    ("text", "token_file", "file with the token; null: the environment variable FELTWIRE_TOKEN has it"),
]

# (name, documentation, [(type, field, documentation)])
STRUCTS = [
    ("hand_options", "How a hand joins a scene. A null text is not given.", [
        ("text", "server", "HOST:PORT of the server's control port"),
        ("text", "fingerprint", "of the server's certificate; or:"),
        ("text", "fingerprint_file", "the file with it; or:"),
        ("text", "ca_file", "file (PEM) of the authorities to trust"),
        ("text", "token_file", "file with the client's token"),
        ("text", "scene", "name of the scene to join"),
        ("text", "name", "of this client, for the server's log"),
        ("text", "device", "as --device of feltwire-client: \"simulated\", \"haply\", \"plugin:FILE.so\". \"caller\": the program "
         "moves the hand and applies its force, by fw_hand_exchange(). \"stepped\": it makes the ticks too, by fw_hand_step()"),
        ("text", "spec", "a built-in specification of the device, or FILE.json; null: the device's own"),
        ("f64", "duration", "[s] after which the run ends; 0: at fw_hand_close()"),
        ("f64", "stale_after", "[s] after which a hand of device \"caller\" that was not moved gets no force: 0.001 to less than a quarter of the hold time"),
        ("texts", "more", "further options of feltwire-client: \"--record\", \"a.mcap\", ...; its --help-all lists them"),
        ("u32", "more_count", "number of these words"),
    ]),
    ("pose", "A place of the tool, in the world frame.", [
        ("f64[3]", "position", "[m]"),
        ("f64[4]", "orientation", "unit quaternion w, x, y, z; a device that senses no rotation ignores it"),
        ("u32", "buttons", "a bit each; the first is bit 0"),
        ("u32", "deadman", "1: the person holds the enabling switch that lets the hand lead a robot"),
        ("f64", "gripper", "[m] the wanted opening of the robot's gripper; below 0: the hand has no lever for it"),
    ]),
    ("session", "What the server granted.", [
        ("u64", "number", "of the session at the server"),
        ("f64", "servo_period", "[s] between two ticks"),
        ("f64", "hold_time", "[s] a force is held without a newer command; it fades from half of it on"),
        ("f64", "stiffness", "[N/m] of the stiffest surface of the scene; 0: not known"),
        ("f64[3]", "start_position", "[m] a point on a surface, where a hand that does not know the scene should begin"),
        ("f64[3]", "start_normal", "unit normal of the surface there"),
    ]),
    ("tick", "A tick of the servo.", [
        ("u64", "number", "of the tick, from 1"),
        ("f64", "time", "[s] since the first tick"),
        ("f64[3]", "position", "[m] of the tool, world frame"),
        ("f64[4]", "orientation", "unit quaternion w, x, y, z"),
        ("f64[3]", "force", "[N] on the hand from this tick on"),
        ("f64[3]", "torque", "[N m] on the hand from this tick on"),
        ("f64", "reply_age", "[s] age of the newest command of the scene; -1: there is none yet"),
        ("f64", "balance", "[J] balance of the energy account; not a number: there is no account"),
        ("f64", "account_cut", "share of the command that the account took off, 0 to 1"),
        ("u32", "zero_force_reason", "why the force is zero: fw_zero_force_text(); 0: it is not zero, or nothing is touched"),
        ("u32", "connected", "1: the session is alive; 0: it is lost, and the hand looks for it"),
        ("f64[3]", "scene_force", "[N] of the newest command of the scene, on the hand: before the bound, the account and the limits"),
        ("u32", "lead_state", "of a hand that leads a robot: fw_lead_state_text(); 0: it leads none, or the robot is missing"),
    ]),
    ("world_options", "How a hand meets the physics of the program. A null text is not given.", [
        ("text", "name", "of this hand, for its recording"),
        ("text", "device", "as in hand_options"),
        ("text", "spec", "as in hand_options"),
        ("f64", "duration", "[s] after which the run ends; 0: at fw_hand_close()"),
        ("f64", "stale_after", "as in hand_options"),
        ("f64", "stiffness", "[N/m] above 0: of the stiffest surface that the hand will meet"),
        ("f64[3]", "start_position", "[m] a point on a surface, where a hand that does not know the scene begins"),
        ("f64[3]", "start_normal", "unit normal of the surface there"),
        ("texts", "more", "as in hand_options"),
        ("u32", "more_count", "number of these words"),
    ]),
    ("patch", "A surface near the tool, described around its point nearest to the tool. World frame.", [
        ("f64[3]", "point", "[m] on the surface"),
        ("f64[3]", "normal", "unit, towards the free side"),
        ("f64", "stiffness", "[N/m] above 0"),
        ("f64", "curvature", "[1/m] 1 / radius of a ball felt from outside, below 0 from inside; 0: a plane"),
        ("f64[3]", "axis", "unit vector along which the surface is straight (a cylinder); zero: the same curve all ways"),
        ("f64[3]", "velocity", "[m/s] of the surface"),
        ("f64", "radius", "[m] within which the patch is right, from its point; 0: the reach"),
        ("f64", "damping", "[N s/m] along the normal"),
        ("f64", "static_friction", "coefficient, not below dynamic_friction"),
        ("f64", "dynamic_friction", "coefficient"),
        ("f64", "viscous_friction", "[N s/m] against sliding"),
        ("u32", "object", "a number of the program's own, below 65536: friction sticks to an object from one call to the next"),
    ]),
    ("wrench", "A force and a torque of the surroundings on the hand. World frame.", [
        ("f64", "time", "[s] fw_tick.time of the pose that it is for"),
        ("f64[3]", "force", "[N]"),
        ("f64[3]", "torque", "[N m]"),
        ("f64", "stiffness", "[N/m] of the force when the tool moves along it; 0: not known"),
    ]),
    ("observer_options", "How an observer joins a scene. A null text is not given.", [
        *ACCESS,
        ("text", "scene", "name of the scene to observe"),
        ("text", "name", "of this observer, for the server's log"),
        ("f64", "period", "[s] between two views of the scene, 0.001 to 0.1. A view tells of 6 hands, the next one of the next 6"),
        ("f64", "patience", "[s] for which a lost session is looked for; 0: not at all"),
    ]),
    ("scene_state", "What an observer sees.", [
        ("u64", "number", "of the state, from 1"),
        ("f64", "time", "[s] of its newest view, since the observer was opened"),
        ("f64", "age", "[s] since that view came"),
        ("u32", "hands", "number of hands that are seen"),
        ("u32", "bodies", "number of bodies that move"),
        ("u32", "connected", "1: the session is alive; 0: it is lost and looked for, and nothing is seen"),
        ("u32", "left_out", "times that a hand or body had no room: an observer keeps 1024 hands and 4096 bodies"),
    ]),
    ("seen_hand", "A hand in the scene, as its server tells. World frame.", [
        ("u32", "number", "of its session in the scene, from 1; never used again"),
        ("u32", "states", "a bit each, from bit 0: no sample has come yet, it is silent, touches nothing, touches, samples were lost, the "
         "server's bound reduced the command, it was too large for the device, the movement was refused, the scene recovers, the device "
         "holds less than was commanded, it moves a robot"),
        ("f64", "time", "[s] of the view that told of it, since the observer was opened"),
        ("f64[3]", "position", "[m] of the tool"),
        ("f64[4]", "orientation", "unit quaternion w, x, y, z"),
        ("f64[3]", "force", "[N] on the hand, that its device holds as its client reports"),
        ("f64[3]", "commanded", "[N] on the hand, that the scene commands"),
        ("f64[3]", "proxy", "[m] place of the tool if it could enter no surface"),
        ("f64", "depth", "[m] of the tool in the object in which it is deepest"),
        ("f64", "delivered", "[J] to the hand so far"),
        ("f64", "burned", "[J] lower bound of the energy that the device has burned so far"),
        ("f64", "balance", "[J] of the client's energy account; not a number: it told none"),
        ("f64", "round_trip", "[s] of the client's newest answer; not a number: it told none"),
        ("u64", "samples", "that the server has taken so far"),
        ("u64", "missed", "samples that were lost on the way so far"),
        ("u32", "tool", "its index among the tools of the scene"),
    ]),
    ("seen_body", "A body that moves. World frame.", [
        ("u32", "object", "its index in the scene"),
        ("f64", "time", "[s] of the view that told of it, since the observer was opened"),
        ("f64[3]", "position", "[m]"),
        ("f64[4]", "orientation", "unit quaternion w, x, y, z"),
    ]),
    ("admin_options", "Which server an admin changes. A null text is not given.", [*ACCESS]),
    ("follower_options", "A robot, and the seat of a scene that it takes. A null text is not given.", [
        *ACCESS,
        ("text", "scene", "name of the scene that has the robot's seat"),
        ("text", "seat", "name of the seat; null: the only seat of the scene"),
        ("text", "name", "of this client, for the server's log"),
        ("text", "robot", "kind of the robot, for the server's log"),
        ("f64", "period", "[s] between two samples of the library's loop, 0.0001 to 0.05. The program's own loop may have another rate"),
        ("f64", "stiffness", "[N/m] above 0: of the robot's own impedance controller"),
        ("f64", "damping", "[N s/m] of that controller"),
        ("f64", "own_damping", "[N s/m] that the robot's body has for certain"),
        ("f64", "mass", "[kg] that shows at the tool; 0: not known"),
        ("f64", "wrench_noise", "[N] largest error of a measured force"),
        ("f64", "gripper_opening", "[m] largest opening of the gripper; 0: there is none"),
        ("f64", "speed", "[m/s] limit of the target"),
        ("f64", "acceleration", "[m/s^2] limit of the target"),
        ("f64", "jerk", "[m/s^3] limit of the target"),
        ("f64", "leash", "[N] largest force by which the target pulls the robot"),
        ("f64[3]", "workspace_low", "[m] low corner of a box that limits the target, beside the workspace of the seat"),
        ("f64[3]", "workspace_high", "[m] its high corner; both corners 0: there is no box"),
        ("f64", "duration", "[s] after which the run ends; 0: at fw_follower_stop()"),
        ("f64", "patience", "[s] for which a lost session is looked for; 0: not at all"),
        ("u32", "locked", "axes that stay as they are while a hand is engaged, a bit each, from bit 0: x, y, z, rotation"),
        ("u32", "estimates_force", "1: robot_state.force is an estimate, and not measured"),
    ]),
    ("robot_state", "A robot, as its program measures it. The robot's own world frame.", [
        ("f64[3]", "position", "[m] of the tool"),
        ("f64[4]", "orientation", "of the tool, unit quaternion w, x, y, z"),
        ("f64[3]", "velocity", "[m/s] of the tool"),
        ("f64[3]", "turning", "[rad/s] of the tool"),
        ("f64[3]", "force", "[N] of the environment on the tool, if has_force is 1"),
        ("f64[3]", "torque", "[N m] of the environment on the tool, about the tool"),
        ("f64[3]", "commanded_position", "[m] of the target that the robot's controller holds now"),
        ("f64[4]", "commanded_orientation", "of that target, unit quaternion w, x, y, z"),
        ("f64", "gripper", "[m] opening"),
        ("f64", "gripper_force", "[N] that the gripper holds with"),
        ("u32", "has_force", "1: the force is known. A force that is not known is not zero"),
        ("u32", "condition", "0: the robot is well; 1: a protective stop, or its people hold it; 2: it has a fault"),
    ]),
    ("robot_target", "What a robot is to do. The robot's own world frame.", [
        ("u64", "number", "of the sample of the library's loop, from 1"),
        ("u64", "sample", "of the leading hand, counted from 1, from which the newest command comes; 0: none"),
        ("f64[3]", "position", "[m] target of the tool, for the robot's controller"),
        ("f64[4]", "orientation", "of the target, unit quaternion w, x, y, z"),
        ("f64", "gripper", "[m] wanted opening"),
        ("f64", "age", "[s] of the newest command; -1: there is none yet. Above 0.1 s the target stands still"),
        ("u32", "state", "of hand and robot in the newest command: fw_lead_state_text(). 2: a hand is engaged, and the target follows it"),
        ("u32", "connected", "1: the session is alive; 0: it is lost and looked for, and the target stands still"),
    ]),
    ("recorder_options", "Where a recording goes. A null text is not given.", [
        ("text", "file", "FILE.mcap"),
        ("f64", "mebibytes", "[MiB] after which the next of several files begins, FILE-0001.mcap; 0: one file"),
        ("f64", "seconds", "[s] after which the next of several files begins; 0: one file"),
        ("u32", "replace", "1: a file that is there is replaced; 0: it is an error"),
    ]),
    ("recording_state", "How far a recording is.", [
        ("u64", "ticks", "that are in it or wait to be written"),
        ("u64", "lost", "ticks that had no room, because the disk was too slow: 16384 wait at most"),
        ("u32", "failed", "1: a file can be written no more; fw_recorder_close() says why"),
    ]),
]

# (result, name, [(type, name)], thread word, documentation)
ANY, ONE, FREE = "any thread", "one thread at a time", "any thread, never waits"
FUNCTIONS = [
    ("u32", "version", [], ANY, "The version of the library: major * 65536 + minor * 256 + patch."),
    ("text", "last_error", [], ANY, "The text of the last error of the calling thread, in one line; empty: there was none."),
    ("text", "result_text", [("i32", "result")], ANY, "What a result means, in one sentence."),
    ("text", "zero_force_text", [("u32", "reason")], ANY, "Why there is no force: \"the hand touches nothing\"; empty: no such reason."),
    ("void", "hand_options_default", [("hand_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("void", "pose_default", [("pose*", "pose"), ("u32", "struct_size")], ANY, "The origin, not turned."),
    ("i32", "hand_open", [("const hand_options*", "options"), ("hand**", "hand")], ANY,
     "Joins a scene, and runs the hand's servo in a thread of its own, with the energy account and the limits of feltwire-client. "
     "Blocks until the server has answered, and a device may make it wait for a person (homing). The hand must be closed."),
    ("i32", "hand_session", [("const hand*", "hand"), ("session*", "session"), ("u32", "struct_size")], ANY,
     "What the server granted when the hand joined."),
    ("i32", "hand_exchange", [("hand*", "hand"), ("const pose*", "pose"), ("tick*", "tick"), ("u32", "struct_size")],
     "one thread at a time, never waits",
     "For a hand of device \"caller\": gives the pose, and returns the newest tick, whose force the program applies until its next call. "
     "The energy account reckons with that. FW_NOTHING: there was no tick yet, so apply no force. FW_ENDED: the run has ended; apply no "
     "force."),
    ("i32", "hand_step", [("hand*", "hand"), ("const pose*", "pose"), ("tick*", "tick"), ("u32", "struct_size")], ONE,
     "For a hand of device \"stepped\", of a program that has a loop of its own: makes a tick with this pose, and returns it. The program applies "
     "its force until its next call. It blocks until the servo has made the tick. Call it once in a period of the servo (--rate): a call that comes later "
     "is a late tick to the energy account, and one later than a quarter of the hold time takes the force off. FW_NOTHING: there was no tick "
     "within that time, so apply no force. FW_ENDED: the run has ended; apply no force."),
    ("i32", "hand_latest", [("const hand*", "hand"), ("tick*", "tick"), ("u32", "struct_size")], FREE,
     "The newest tick, to watch the hand. FW_NOTHING: there was none yet. Never apply its force: the account does not know of it."),
    ("i32", "hand_ticks", [("hand*", "hand"), ("tick*", "ticks"), ("u32", "struct_size"), ("u32", "most"), ("u32*", "count")],
     "one thread at a time, never waits",
     "Takes the ticks since the last call, at most `most`. After 16384 ticks without a call the newest are lost; their numbers tell it."),
    ("i32", "hand_message", [("hand*", "hand"), ("char*", "text"), ("u32", "size")], ANY,
     "Takes the oldest message for people that was not taken yet: a warning, or a change by an admin. It is cut at `size`, with the zero "
     "byte. FW_NOTHING: there is none."),
    ("i32", "hand_wait", [("hand*", "hand"), ("f64", "timeout")], ANY,
     "Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet."),
    ("i32", "hand_stop", [("hand*", "hand")], ANY, "Lets the force fade and ends the run. Does not wait."),
    ("i32", "hand_close", [("hand*", "hand")], ONE,
     "Ends the run, waits for it, and frees the hand, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had ended the run. Null is allowed."),
    ("void", "world_options_default", [("world_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("void", "patch_default", [("patch*", "patch"), ("u32", "struct_size")], ANY, "A plane of 1000 N/m through the origin, without friction."),
    ("void", "wrench_default", [("wrench*", "wrench"), ("u32", "struct_size")], ANY, "No force."),
    ("i32", "hand_open_world", [("const world_options*", "options"), ("hand**", "hand")], ANY,
     "Opens a hand that meets the physics of the program in place of a server's scene. All functions of a hand work with it. The program "
     "calls fw_hand_touch() or fw_hand_push() 60 to 1000 times a second; if it stops, the force fades within the hold time."),
    ("i32", "hand_touch", [("hand*", "hand"), ("f64", "time"), ("f64", "reach"), ("const patch*", "patches"), ("u32", "struct_size"), ("u32", "count")],
     "one thread at a time, never waits",
     "For a hand of fw_hand_open_world(): says which surfaces are within `reach` [m] of the tool, at most 3; 0: none is. `time` [s]: fw_tick.time of "
     "the position that the physics used. The hand feels them at its servo rate until the next call, within the hold time. FW_NOTHING: the hand "
     "does not take them, because there was no tick yet, `time` is older than the hold time or than that of the last call, or its servo stands still. FW_ENDED: the run has ended."),
    ("i32", "hand_push", [("hand*", "hand"), ("const wrench*", "wrench")], "one thread at a time, never waits",
     "The same, for physics that knows a force only. With a stiffness the hand feels the plane that has this force at that position. Without "
     "one it feels the force as it is, as far as its account pays for it. Prefer fw_hand_touch(): a patch is felt before it pushes."),
    ("void", "observer_options_default", [("observer_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("i32", "observer_open", [("const observer_options*", "options"), ("observer**", "observer")], ANY,
     "Joins a scene as an observer: it has no hand, and sees all hands and moving bodies. Blocks until the server has answered. A thread of "
     "the library takes the views. The observer must be closed."),
    ("i32", "observer_latest", [("const observer*", "observer"), ("scene_state*", "state"), ("u32", "struct_size")], FREE,
     "The newest state. FW_NOTHING: no view has come yet."),
    ("i32", "observer_hands", [("const observer*", "observer"), ("seen_hand*", "hands"), ("u32", "struct_size"), ("u32", "most"), ("u32*", "count")],
     FREE, "The hands of the newest state, by rising number, at most `most`. FW_NOTHING: no view has come yet."),
    ("i32", "observer_bodies", [("const observer*", "observer"), ("seen_body*", "bodies"), ("u32", "struct_size"), ("u32", "most"),
                                ("u32*", "count")],
     FREE, "The moving bodies of the newest state, by rising object, at most `most`. FW_NOTHING: no view has come yet."),
    ("i32", "observer_hand_name", [("observer*", "observer"), ("u32", "number"), ("char*", "text"), ("u32", "size")], ANY,
     "The name that the client of a hand gives itself. The library asks the server for it when a hand has come. It is cut at `size`, with the "
     "zero byte. FW_NOTHING: it is not known yet, or there is no such hand."),
    ("i32", "observer_message", [("observer*", "observer"), ("char*", "text"), ("u32", "size")], ANY,
     "Takes the oldest message for people that was not taken yet: the session was lost, or is there again. It is cut at `size`, with the zero "
     "byte. FW_NOTHING: there is none."),
    ("i32", "observer_wait", [("observer*", "observer"), ("u64", "number"), ("f64", "timeout")], ANY,
     "Waits for a state with a greater number, at most `timeout` [s]. FW_OK: it is there; FW_NOTHING: not yet; FW_ENDED: there will be none, "
     "and fw_last_error() says why."),
    ("i32", "observer_close", [("observer*", "observer")], ONE,
     "Leaves the scene and frees the observer, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had ended it. "
     "Null is allowed."),
    ("void", "admin_options_default", [("admin_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("i32", "admin_open", [("const admin_options*", "options"), ("admin**", "admin")], ANY,
     "Reads the credentials, and asks the server for its scenes, so that an address or a token that is wrong is known at once. Blocks. No "
     "connection stays open. The admin must be closed."),
    ("i32", "admin_request", [("admin*", "admin"), ("texts", "words"), ("u32", "count"), ("text*", "answer")], ONE,
     "Runs a command with the words of `feltwire-client admin` (docs/admin.md): \"sessions\", or \"evict\", \"3\". Blocks until it is done. "
     "Sets `answer` to its answer as JSON, which is valid until the next call with this admin; null where the command failed."),
    ("i32", "admin_close", [("admin*", "admin")], ONE, "Frees the admin, which no other call may use meanwhile. Null is allowed."),
    ("text", "lead_state_text", [("u32", "state")], ANY, "The name of the state between a hand and a robot, such as \"engaged\"; empty: there is no such state."),
    ("void", "follower_options_default", [("follower_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("void", "robot_state_default", [("robot_state*", "state"), ("u32", "struct_size")], ANY,
     "At the origin, not turned, at rest, well, its force not known."),
    ("i32", "follower_open", [("const follower_options*", "options"), ("follower**", "follower")], ANY,
     "Takes a seat for a robot, and runs the follower's loop of feltwire-follower in a thread of its own. Blocks until the server has "
     "answered. The follower must be closed."),
    ("i32", "follower_exchange", [("follower*", "follower"), ("const robot_state*", "state"), ("robot_target*", "target"), ("u32", "struct_size")],
     "one thread at a time, never waits",
     "Gives the robot's newest state, and returns the newest target, which the robot's controller gets. Call it at the rate of the robot's own "
     "loop, 100 to 1000 Hz. A robot that was not heard of for 0.1 s, that is stopped or that has a fault is not led: its target is where it "
     "is told to be already. FW_NOTHING: there is no target yet, so the robot stays. FW_ENDED: the run has ended; the robot stays at this "
     "target."),
    ("i32", "follower_latest", [("const follower*", "follower"), ("robot_target*", "target"), ("u32", "struct_size")], FREE,
     "The newest target, to watch the robot. FW_NOTHING: there is none yet."),
    ("i32", "follower_message", [("follower*", "follower"), ("char*", "text"), ("u32", "size")], ANY,
     "Takes the oldest message for people that was not taken yet: the seat was lost, or the robot has it again. It is cut at `size`, with the "
     "zero byte. FW_NOTHING: there is none."),
    ("i32", "follower_wait", [("follower*", "follower"), ("f64", "timeout")], ANY,
     "Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet."),
    ("i32", "follower_stop", [("follower*", "follower")], ANY,
     "Leaves the scene. The target brakes for 0.25 s, then the run ends. Does not wait: call fw_follower_exchange() until FW_ENDED."),
    ("i32", "follower_close", [("follower*", "follower")], ONE,
     "Ends the run, waits for it, and frees the follower, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had "
     "ended the run. Null is allowed."),
    ("void", "recorder_options_default", [("recorder_options*", "options"), ("u32", "struct_size")], ANY,
     "Fills in the usual options. Call it first, with sizeof."),
    ("i32", "recorder_open", [("hand*", "hand"), ("const recorder_options*", "options"), ("recorder**", "recorder")], ANY,
     "Records every tick of a hand from its next tick on, as --record of feltwire-client does. One recording of a hand at a time. A thread of "
     "the library writes. The recorder must be closed; the hand may be closed before."),
    ("i32", "recorder_mark", [("recorder*", "recorder"), ("text", "text")], ANY,
     "Writes a text at this moment into the recording: a metadata record `mark` with `text` and `time` [ns since 1970]. "
     "A text that is not UTF-8 is refused."),
    ("i32", "recorder_state", [("const recorder*", "recorder"), ("recording_state*", "state"), ("u32", "struct_size")], FREE, "How far the recording is."),
    ("i32", "recorder_close", [("recorder*", "recorder")], ONE,
     "Writes the rest, waits until it is on the disk, and frees the recorder, which no other call may use meanwhile. FW_OK, or "
     "FW_ERROR_DEVICE with a text: a file is not complete, or ticks were lost. Null is allowed."),
]

# (title, first of its functions) of the parts of docs/c_reference.md. A struct stands in the part whose function takes it first.
PARTS = [
    ("Errors and texts", "version"),
    ("A hand", "hand_options_default"),
    ("A hand in the physics of the program", "world_options_default"),
    ("An observer", "observer_options_default"),
    ("An admin", "admin_options_default"),
    ("A robot that follows", "lead_state_text"),
    ("A recording", "recorder_options_default"),
]

# The version that brought a function, where it is not 0.1.0.
SINCE = {}
