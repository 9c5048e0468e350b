// The C interface of feltwire for C#. Written by make_bindings.py from api_table.py. Change the table.
// All structs are blittable.
using System;
using System.Runtime.InteropServices;

namespace Feltwire
{
    public static class Native
    {
        public const int Ok = 0;  // It is done.
        public const int Nothing = 1;  // There is nothing yet, or nothing new.
        public const int Ended = 2;  // The hand's run, the observer or the follower has ended. fw_last_error() says why, if an error ended it.
        public const int ErrorArgument = -1;  // An argument is null, or an option is wrong. fw_last_error() names it and the remedy.
        public const int ErrorRefused = -2;  // The server refuses for good: the token, the scene, the device or a parameter.
        public const int ErrorServer = -3;  // The server is not reachable, not trusted, or full. Trying again may help.
        public const int ErrorDevice = -4;  // The device or a file cannot be opened.
        public const int ErrorMemory = -5;  // There is no memory for it.
        public const int ErrorInternal = -6;  // Anything else. fw_last_error() has the text.

        /// <summary>How a hand joins a scene. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 112)]
        public struct HandOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr server;  // HOST:PORT of the server's control port
            [FieldOffset(16)] public IntPtr fingerprint;  // of the server's certificate; or:
            [FieldOffset(24)] public IntPtr fingerprint_file;  // the file with it; or:
            [FieldOffset(32)] public IntPtr ca_file;  // file (PEM) of the authorities to trust
            [FieldOffset(40)] public IntPtr token_file;  // file with the client's token
            [FieldOffset(48)] public IntPtr scene;  // name of the scene to join
            [FieldOffset(56)] public IntPtr name;  // of this client, for the server's log
            [FieldOffset(64)] public IntPtr device;  // as --device of feltwire-client: "simulated", "haply", "plugin:FILE.so". "caller": the program moves the hand and applies its force, by fw_hand_exchange(). "stepped": it makes the ticks too, by fw_hand_step()
            [FieldOffset(72)] public IntPtr spec;  // a built-in specification of the device, or FILE.json; null: the device's own
            [FieldOffset(80)] public double duration;  // [s] after which the run ends; 0: at fw_hand_close()
            [FieldOffset(88)] public double stale_after;  // [s] after which a hand of device "caller" that was not moved gets no force: 0.001 to less than a quarter of the hold time
            [FieldOffset(96)] public IntPtr more;  // further options of feltwire-client: "--record", "a.mcap", ...; its --help-all lists them
            [FieldOffset(104)] public uint more_count;  // number of these words
        }

        /// <summary>A place of the tool, in the world frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 80)]
        public struct Pose
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public double position_0;  // [m]
            [FieldOffset(16)] public double position_1;  // [m]
            [FieldOffset(24)] public double position_2;  // [m]
            [FieldOffset(32)] public double orientation_0;  // unit quaternion w, x, y, z; a device that senses no rotation ignores it
            [FieldOffset(40)] public double orientation_1;  // unit quaternion w, x, y, z; a device that senses no rotation ignores it
            [FieldOffset(48)] public double orientation_2;  // unit quaternion w, x, y, z; a device that senses no rotation ignores it
            [FieldOffset(56)] public double orientation_3;  // unit quaternion w, x, y, z; a device that senses no rotation ignores it
            [FieldOffset(64)] public uint buttons;  // a bit each; the first is bit 0
            [FieldOffset(68)] public uint deadman;  // 1: the person holds the enabling switch that lets the hand lead a robot
            [FieldOffset(72)] public double gripper;  // [m] the wanted opening of the robot's gripper; below 0: the hand has no lever for it
        }

        /// <summary>What the server granted.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 88)]
        public struct Session
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public ulong number;  // of the session at the server
            [FieldOffset(16)] public double servo_period;  // [s] between two ticks
            [FieldOffset(24)] public double hold_time;  // [s] a force is held without a newer command; it fades from half of it on
            [FieldOffset(32)] public double stiffness;  // [N/m] of the stiffest surface of the scene; 0: not known
            [FieldOffset(40)] public double start_position_0;  // [m] a point on a surface, where a hand that does not know the scene should begin
            [FieldOffset(48)] public double start_position_1;  // [m] a point on a surface, where a hand that does not know the scene should begin
            [FieldOffset(56)] public double start_position_2;  // [m] a point on a surface, where a hand that does not know the scene should begin
            [FieldOffset(64)] public double start_normal_0;  // unit normal of the surface there
            [FieldOffset(72)] public double start_normal_1;  // unit normal of the surface there
            [FieldOffset(80)] public double start_normal_2;  // unit normal of the surface there
        }

        /// <summary>A tick of the servo.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 192)]
        public struct Tick
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public ulong number;  // of the tick, from 1
            [FieldOffset(16)] public double time;  // [s] since the first tick
            [FieldOffset(24)] public double position_0;  // [m] of the tool, world frame
            [FieldOffset(32)] public double position_1;  // [m] of the tool, world frame
            [FieldOffset(40)] public double position_2;  // [m] of the tool, world frame
            [FieldOffset(48)] public double orientation_0;  // unit quaternion w, x, y, z
            [FieldOffset(56)] public double orientation_1;  // unit quaternion w, x, y, z
            [FieldOffset(64)] public double orientation_2;  // unit quaternion w, x, y, z
            [FieldOffset(72)] public double orientation_3;  // unit quaternion w, x, y, z
            [FieldOffset(80)] public double force_0;  // [N] on the hand from this tick on
            [FieldOffset(88)] public double force_1;  // [N] on the hand from this tick on
            [FieldOffset(96)] public double force_2;  // [N] on the hand from this tick on
            [FieldOffset(104)] public double torque_0;  // [N m] on the hand from this tick on
            [FieldOffset(112)] public double torque_1;  // [N m] on the hand from this tick on
            [FieldOffset(120)] public double torque_2;  // [N m] on the hand from this tick on
            [FieldOffset(128)] public double reply_age;  // [s] age of the newest command of the scene; -1: there is none yet
            [FieldOffset(136)] public double balance;  // [J] balance of the energy account; not a number: there is no account
            [FieldOffset(144)] public double account_cut;  // share of the command that the account took off, 0 to 1
            [FieldOffset(152)] public uint zero_force_reason;  // why the force is zero: fw_zero_force_text(); 0: it is not zero, or nothing is touched
            [FieldOffset(156)] public uint connected;  // 1: the session is alive; 0: it is lost, and the hand looks for it
            [FieldOffset(160)] public double scene_force_0;  // [N] of the newest command of the scene, on the hand: before the bound, the account and the limits
            [FieldOffset(168)] public double scene_force_1;  // [N] of the newest command of the scene, on the hand: before the bound, the account and the limits
            [FieldOffset(176)] public double scene_force_2;  // [N] of the newest command of the scene, on the hand: before the bound, the account and the limits
            [FieldOffset(184)] public uint lead_state;  // of a hand that leads a robot: fw_lead_state_text(); 0: it leads none, or the robot is missing
        }

        /// <summary>How a hand meets the physics of the program. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 120)]
        public struct WorldOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr name;  // of this hand, for its recording
            [FieldOffset(16)] public IntPtr device;  // as in hand_options
            [FieldOffset(24)] public IntPtr spec;  // as in hand_options
            [FieldOffset(32)] public double duration;  // [s] after which the run ends; 0: at fw_hand_close()
            [FieldOffset(40)] public double stale_after;  // as in hand_options
            [FieldOffset(48)] public double stiffness;  // [N/m] above 0: of the stiffest surface that the hand will meet
            [FieldOffset(56)] public double start_position_0;  // [m] a point on a surface, where a hand that does not know the scene begins
            [FieldOffset(64)] public double start_position_1;  // [m] a point on a surface, where a hand that does not know the scene begins
            [FieldOffset(72)] public double start_position_2;  // [m] a point on a surface, where a hand that does not know the scene begins
            [FieldOffset(80)] public double start_normal_0;  // unit normal of the surface there
            [FieldOffset(88)] public double start_normal_1;  // unit normal of the surface there
            [FieldOffset(96)] public double start_normal_2;  // unit normal of the surface there
            [FieldOffset(104)] public IntPtr more;  // as in hand_options
            [FieldOffset(112)] public uint more_count;  // number of these words
        }

        /// <summary>A surface near the tool, described around its point nearest to the tool. World frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 168)]
        public struct Patch
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public double point_0;  // [m] on the surface
            [FieldOffset(16)] public double point_1;  // [m] on the surface
            [FieldOffset(24)] public double point_2;  // [m] on the surface
            [FieldOffset(32)] public double normal_0;  // unit, towards the free side
            [FieldOffset(40)] public double normal_1;  // unit, towards the free side
            [FieldOffset(48)] public double normal_2;  // unit, towards the free side
            [FieldOffset(56)] public double stiffness;  // [N/m] above 0
            [FieldOffset(64)] public double curvature;  // [1/m] 1 / radius of a ball felt from outside, below 0 from inside; 0: a plane
            [FieldOffset(72)] public double axis_0;  // unit vector along which the surface is straight (a cylinder); zero: the same curve all ways
            [FieldOffset(80)] public double axis_1;  // unit vector along which the surface is straight (a cylinder); zero: the same curve all ways
            [FieldOffset(88)] public double axis_2;  // unit vector along which the surface is straight (a cylinder); zero: the same curve all ways
            [FieldOffset(96)] public double velocity_0;  // [m/s] of the surface
            [FieldOffset(104)] public double velocity_1;  // [m/s] of the surface
            [FieldOffset(112)] public double velocity_2;  // [m/s] of the surface
            [FieldOffset(120)] public double radius;  // [m] within which the patch is right, from its point; 0: the reach
            [FieldOffset(128)] public double damping;  // [N s/m] along the normal
            [FieldOffset(136)] public double static_friction;  // coefficient, not below dynamic_friction
            [FieldOffset(144)] public double dynamic_friction;  // coefficient
            [FieldOffset(152)] public double viscous_friction;  // [N s/m] against sliding
            [FieldOffset(160)] public uint object;  // a number of the program's own, below 65536: friction sticks to an object from one call to the next
        }

        /// <summary>A force and a torque of the surroundings on the hand. World frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 72)]
        public struct Wrench
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public double time;  // [s] fw_tick.time of the pose that it is for
            [FieldOffset(16)] public double force_0;  // [N]
            [FieldOffset(24)] public double force_1;  // [N]
            [FieldOffset(32)] public double force_2;  // [N]
            [FieldOffset(40)] public double torque_0;  // [N m]
            [FieldOffset(48)] public double torque_1;  // [N m]
            [FieldOffset(56)] public double torque_2;  // [N m]
            [FieldOffset(64)] public double stiffness;  // [N/m] of the force when the tool moves along it; 0: not known
        }

        /// <summary>How an observer joins a scene. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 96)]
        public struct ObserverOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr server;  // HOST:PORT of the server's control port
            [FieldOffset(16)] public IntPtr fingerprint;  // of the server's certificate; or:
            [FieldOffset(24)] public IntPtr fingerprint_file;  // the file with it; or:
            [FieldOffset(32)] public IntPtr ca_file;  // file (PEM) of the authorities to trust
            [FieldOffset(40)] public IntPtr certificate_file;  // file (PEM) of the client's certificate, for a server that asks for one
            [FieldOffset(48)] public IntPtr key_file;  // file (PEM) of the key of that certificate
            [FieldOffset(56)] public IntPtr token_file;  // file with the token; null: the environment variable FELTWIRE_TOKEN has it
            [FieldOffset(64)] public IntPtr scene;  // name of the scene to observe
            [FieldOffset(72)] public IntPtr name;  // of this observer, for the server's log
            [FieldOffset(80)] public double period;  // [s] between two views of the scene, 0.001 to 0.1. A view tells of 6 hands, the next one of the next 6
            [FieldOffset(88)] public double patience;  // [s] for which a lost session is looked for; 0: not at all
        }

        /// <summary>What an observer sees.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 48)]
        public struct SceneState
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public ulong number;  // of the state, from 1
            [FieldOffset(16)] public double time;  // [s] of its newest view, since the observer was opened
            [FieldOffset(24)] public double age;  // [s] since that view came
            [FieldOffset(32)] public uint hands;  // number of hands that are seen
            [FieldOffset(36)] public uint bodies;  // number of bodies that move
            [FieldOffset(40)] public uint connected;  // 1: the session is alive; 0: it is lost and looked for, and nothing is seen
            [FieldOffset(44)] public uint left_out;  // times that a hand or body had no room: an observer keeps 1024 hands and 4096 bodies
        }

        /// <summary>A hand in the scene, as its server tells. World frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 216)]
        public struct SeenHand
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public uint number;  // of its session in the scene, from 1; never used again
            [FieldOffset(12)] public uint states;  // a bit each, from bit 0: no sample has come yet, it is silent, touches nothing, touches, samples were lost, the server's bound reduced the command, it was too large for the device, the movement was refused, the scene recovers, the device holds less than was commanded, it moves a robot
            [FieldOffset(16)] public double time;  // [s] of the view that told of it, since the observer was opened
            [FieldOffset(24)] public double position_0;  // [m] of the tool
            [FieldOffset(32)] public double position_1;  // [m] of the tool
            [FieldOffset(40)] public double position_2;  // [m] of the tool
            [FieldOffset(48)] public double orientation_0;  // unit quaternion w, x, y, z
            [FieldOffset(56)] public double orientation_1;  // unit quaternion w, x, y, z
            [FieldOffset(64)] public double orientation_2;  // unit quaternion w, x, y, z
            [FieldOffset(72)] public double orientation_3;  // unit quaternion w, x, y, z
            [FieldOffset(80)] public double force_0;  // [N] on the hand, that its device holds as its client reports
            [FieldOffset(88)] public double force_1;  // [N] on the hand, that its device holds as its client reports
            [FieldOffset(96)] public double force_2;  // [N] on the hand, that its device holds as its client reports
            [FieldOffset(104)] public double commanded_0;  // [N] on the hand, that the scene commands
            [FieldOffset(112)] public double commanded_1;  // [N] on the hand, that the scene commands
            [FieldOffset(120)] public double commanded_2;  // [N] on the hand, that the scene commands
            [FieldOffset(128)] public double proxy_0;  // [m] place of the tool if it could enter no surface
            [FieldOffset(136)] public double proxy_1;  // [m] place of the tool if it could enter no surface
            [FieldOffset(144)] public double proxy_2;  // [m] place of the tool if it could enter no surface
            [FieldOffset(152)] public double depth;  // [m] of the tool in the object in which it is deepest
            [FieldOffset(160)] public double delivered;  // [J] to the hand so far
            [FieldOffset(168)] public double burned;  // [J] lower bound of the energy that the device has burned so far
            [FieldOffset(176)] public double balance;  // [J] of the client's energy account; not a number: it told none
            [FieldOffset(184)] public double round_trip;  // [s] of the client's newest answer; not a number: it told none
            [FieldOffset(192)] public ulong samples;  // that the server has taken so far
            [FieldOffset(200)] public ulong missed;  // samples that were lost on the way so far
            [FieldOffset(208)] public uint tool;  // its index among the tools of the scene
        }

        /// <summary>A body that moves. World frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 80)]
        public struct SeenBody
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public uint object;  // its index in the scene
            [FieldOffset(16)] public double time;  // [s] of the view that told of it, since the observer was opened
            [FieldOffset(24)] public double position_0;  // [m]
            [FieldOffset(32)] public double position_1;  // [m]
            [FieldOffset(40)] public double position_2;  // [m]
            [FieldOffset(48)] public double orientation_0;  // unit quaternion w, x, y, z
            [FieldOffset(56)] public double orientation_1;  // unit quaternion w, x, y, z
            [FieldOffset(64)] public double orientation_2;  // unit quaternion w, x, y, z
            [FieldOffset(72)] public double orientation_3;  // unit quaternion w, x, y, z
        }

        /// <summary>Which server an admin changes. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 64)]
        public struct AdminOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr server;  // HOST:PORT of the server's control port
            [FieldOffset(16)] public IntPtr fingerprint;  // of the server's certificate; or:
            [FieldOffset(24)] public IntPtr fingerprint_file;  // the file with it; or:
            [FieldOffset(32)] public IntPtr ca_file;  // file (PEM) of the authorities to trust
            [FieldOffset(40)] public IntPtr certificate_file;  // file (PEM) of the client's certificate, for a server that asks for one
            [FieldOffset(48)] public IntPtr key_file;  // file (PEM) of the key of that certificate
            [FieldOffset(56)] public IntPtr token_file;  // file with the token; null: the environment variable FELTWIRE_TOKEN has it
        }

        /// <summary>A robot, and the seat of a scene that it takes. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 256)]
        public struct FollowerOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr server;  // HOST:PORT of the server's control port
            [FieldOffset(16)] public IntPtr fingerprint;  // of the server's certificate; or:
            [FieldOffset(24)] public IntPtr fingerprint_file;  // the file with it; or:
            [FieldOffset(32)] public IntPtr ca_file;  // file (PEM) of the authorities to trust
            [FieldOffset(40)] public IntPtr certificate_file;  // file (PEM) of the client's certificate, for a server that asks for one
            [FieldOffset(48)] public IntPtr key_file;  // file (PEM) of the key of that certificate
            [FieldOffset(56)] public IntPtr token_file;  // file with the token; null: the environment variable FELTWIRE_TOKEN has it
            [FieldOffset(64)] public IntPtr scene;  // name of the scene that has the robot's seat
            [FieldOffset(72)] public IntPtr seat;  // name of the seat; null: the only seat of the scene
            [FieldOffset(80)] public IntPtr name;  // of this client, for the server's log
            [FieldOffset(88)] public IntPtr robot;  // kind of the robot, for the server's log
            [FieldOffset(96)] public double period;  // [s] between two samples of the library's loop, 0.0001 to 0.05. The program's own loop may have another rate
            [FieldOffset(104)] public double stiffness;  // [N/m] above 0: of the robot's own impedance controller
            [FieldOffset(112)] public double damping;  // [N s/m] of that controller
            [FieldOffset(120)] public double own_damping;  // [N s/m] that the robot's body has for certain
            [FieldOffset(128)] public double mass;  // [kg] that shows at the tool; 0: not known
            [FieldOffset(136)] public double wrench_noise;  // [N] largest error of a measured force
            [FieldOffset(144)] public double gripper_opening;  // [m] largest opening of the gripper; 0: there is none
            [FieldOffset(152)] public double speed;  // [m/s] limit of the target
            [FieldOffset(160)] public double acceleration;  // [m/s^2] limit of the target
            [FieldOffset(168)] public double jerk;  // [m/s^3] limit of the target
            [FieldOffset(176)] public double leash;  // [N] largest force by which the target pulls the robot
            [FieldOffset(184)] public double workspace_low_0;  // [m] low corner of a box that limits the target, beside the workspace of the seat
            [FieldOffset(192)] public double workspace_low_1;  // [m] low corner of a box that limits the target, beside the workspace of the seat
            [FieldOffset(200)] public double workspace_low_2;  // [m] low corner of a box that limits the target, beside the workspace of the seat
            [FieldOffset(208)] public double workspace_high_0;  // [m] its high corner; both corners 0: there is no box
            [FieldOffset(216)] public double workspace_high_1;  // [m] its high corner; both corners 0: there is no box
            [FieldOffset(224)] public double workspace_high_2;  // [m] its high corner; both corners 0: there is no box
            [FieldOffset(232)] public double duration;  // [s] after which the run ends; 0: at fw_follower_stop()
            [FieldOffset(240)] public double patience;  // [s] for which a lost session is looked for; 0: not at all
            [FieldOffset(248)] public uint locked;  // axes that stay as they are while a hand is engaged, a bit each, from bit 0: x, y, z, rotation
            [FieldOffset(252)] public uint estimates_force;  // 1: robot_state.force is an estimate, and not measured
        }

        /// <summary>A robot, as its program measures it. The robot's own world frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 240)]
        public struct RobotState
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public double position_0;  // [m] of the tool
            [FieldOffset(16)] public double position_1;  // [m] of the tool
            [FieldOffset(24)] public double position_2;  // [m] of the tool
            [FieldOffset(32)] public double orientation_0;  // of the tool, unit quaternion w, x, y, z
            [FieldOffset(40)] public double orientation_1;  // of the tool, unit quaternion w, x, y, z
            [FieldOffset(48)] public double orientation_2;  // of the tool, unit quaternion w, x, y, z
            [FieldOffset(56)] public double orientation_3;  // of the tool, unit quaternion w, x, y, z
            [FieldOffset(64)] public double velocity_0;  // [m/s] of the tool
            [FieldOffset(72)] public double velocity_1;  // [m/s] of the tool
            [FieldOffset(80)] public double velocity_2;  // [m/s] of the tool
            [FieldOffset(88)] public double turning_0;  // [rad/s] of the tool
            [FieldOffset(96)] public double turning_1;  // [rad/s] of the tool
            [FieldOffset(104)] public double turning_2;  // [rad/s] of the tool
            [FieldOffset(112)] public double force_0;  // [N] of the environment on the tool, if has_force is 1
            [FieldOffset(120)] public double force_1;  // [N] of the environment on the tool, if has_force is 1
            [FieldOffset(128)] public double force_2;  // [N] of the environment on the tool, if has_force is 1
            [FieldOffset(136)] public double torque_0;  // [N m] of the environment on the tool, about the tool
            [FieldOffset(144)] public double torque_1;  // [N m] of the environment on the tool, about the tool
            [FieldOffset(152)] public double torque_2;  // [N m] of the environment on the tool, about the tool
            [FieldOffset(160)] public double commanded_position_0;  // [m] of the target that the robot's controller holds now
            [FieldOffset(168)] public double commanded_position_1;  // [m] of the target that the robot's controller holds now
            [FieldOffset(176)] public double commanded_position_2;  // [m] of the target that the robot's controller holds now
            [FieldOffset(184)] public double commanded_orientation_0;  // of that target, unit quaternion w, x, y, z
            [FieldOffset(192)] public double commanded_orientation_1;  // of that target, unit quaternion w, x, y, z
            [FieldOffset(200)] public double commanded_orientation_2;  // of that target, unit quaternion w, x, y, z
            [FieldOffset(208)] public double commanded_orientation_3;  // of that target, unit quaternion w, x, y, z
            [FieldOffset(216)] public double gripper;  // [m] opening
            [FieldOffset(224)] public double gripper_force;  // [N] that the gripper holds with
            [FieldOffset(232)] public uint has_force;  // 1: the force is known. A force that is not known is not zero
            [FieldOffset(236)] public uint condition;  // 0: the robot is well; 1: a protective stop, or its people hold it; 2: it has a fault
        }

        /// <summary>What a robot is to do. The robot's own world frame.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 104)]
        public struct RobotTarget
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public ulong number;  // of the sample of the library's loop, from 1
            [FieldOffset(16)] public ulong sample;  // of the leading hand, counted from 1, from which the newest command comes; 0: none
            [FieldOffset(24)] public double position_0;  // [m] target of the tool, for the robot's controller
            [FieldOffset(32)] public double position_1;  // [m] target of the tool, for the robot's controller
            [FieldOffset(40)] public double position_2;  // [m] target of the tool, for the robot's controller
            [FieldOffset(48)] public double orientation_0;  // of the target, unit quaternion w, x, y, z
            [FieldOffset(56)] public double orientation_1;  // of the target, unit quaternion w, x, y, z
            [FieldOffset(64)] public double orientation_2;  // of the target, unit quaternion w, x, y, z
            [FieldOffset(72)] public double orientation_3;  // of the target, unit quaternion w, x, y, z
            [FieldOffset(80)] public double gripper;  // [m] wanted opening
            [FieldOffset(88)] public double age;  // [s] of the newest command; -1: there is none yet. Above 0.1 s the target stands still
            [FieldOffset(96)] public uint state;  // of hand and robot in the newest command: fw_lead_state_text(). 2: a hand is engaged, and the target follows it
            [FieldOffset(100)] public uint connected;  // 1: the session is alive; 0: it is lost and looked for, and the target stands still
        }

        /// <summary>Where a recording goes. A null text is not given.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 40)]
        public struct RecorderOptions
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public IntPtr file;  // FILE.mcap
            [FieldOffset(16)] public double mebibytes;  // [MiB] after which the next of several files begins, FILE-0001.mcap; 0: one file
            [FieldOffset(24)] public double seconds;  // [s] after which the next of several files begins; 0: one file
            [FieldOffset(32)] public uint replace;  // 1: a file that is there is replaced; 0: it is an error
        }

        /// <summary>How far a recording is.</summary>
        [StructLayout(LayoutKind.Explicit, Size = 32)]
        public struct RecordingState
        {
            [FieldOffset(0)] public uint struct_size;  // [bytes] of this struct, as the program knows it
            [FieldOffset(4)] public uint reserved;  // 0
            [FieldOffset(8)] public ulong ticks;  // that are in it or wait to be written
            [FieldOffset(16)] public ulong lost;  // ticks that had no room, because the disk was too slow: 16384 wait at most
            [FieldOffset(24)] public uint failed;  // 1: a file can be written no more; fw_recorder_close() says why
        }

        /// <summary>The version of the library: major * 65536 + minor * 256 + patch. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern uint fw_version();

        /// <summary>The text of the last error of the calling thread, in one line; empty: there was none. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern IntPtr fw_last_error();

        /// <summary>What a result means, in one sentence. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern IntPtr fw_result_text(int result);

        /// <summary>Why there is no force: "the hand touches nothing"; empty: no such reason. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern IntPtr fw_zero_force_text(uint reason);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_hand_options_default(ref HandOptions options, uint struct_size);

        /// <summary>The origin, not turned. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_pose_default(ref Pose pose, uint struct_size);

        /// <summary>Joins a scene, and runs the hand's servo in a thread of its own, with the energy account and the limits of feltwire-client. Blocks until the server has answered, and a device may make it wait for a person (homing). The hand must be closed. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_open(ref HandOptions options, out IntPtr hand);

        /// <summary>What the server granted when the hand joined. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_session(IntPtr hand, ref Session session, uint struct_size);

        /// <summary>For a hand of device "caller": gives the pose, and returns the newest tick, whose force the program applies until its next call. The energy account reckons with that. FW_NOTHING: there was no tick yet, so apply no force. FW_ENDED: the run has ended; apply no force. Threads: one thread at a time, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_exchange(IntPtr hand, ref Pose pose, ref Tick tick, uint struct_size);

        /// <summary>For a hand of device "stepped", of a program that has a loop of its own: makes a tick with this pose, and returns it. The program applies its force until its next call. It blocks until the servo has made the tick. Call it once in a period of the servo (--rate): a call that comes later is a late tick to the energy account, and one later than a quarter of the hold time takes the force off. FW_NOTHING: there was no tick within that time, so apply no force. FW_ENDED: the run has ended; apply no force. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_step(IntPtr hand, ref Pose pose, ref Tick tick, uint struct_size);

        /// <summary>The newest tick, to watch the hand. FW_NOTHING: there was none yet. Never apply its force: the account does not know of it. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_latest(IntPtr hand, ref Tick tick, uint struct_size);

        /// <summary>Takes the ticks since the last call, at most `most`. After 16384 ticks without a call the newest are lost; their numbers tell it. Threads: one thread at a time, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_ticks(IntPtr hand, ref Tick ticks, uint struct_size, uint most, out uint count);

        /// <summary>Takes the oldest message for people that was not taken yet: a warning, or a change by an admin. It is cut at `size`, with the zero byte. FW_NOTHING: there is none. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_message(IntPtr hand, byte[] text, uint size);

        /// <summary>Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_wait(IntPtr hand, double timeout);

        /// <summary>Lets the force fade and ends the run. Does not wait. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_stop(IntPtr hand);

        /// <summary>Ends the run, waits for it, and frees the hand, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had ended the run. Null is allowed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_close(IntPtr hand);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_world_options_default(ref WorldOptions options, uint struct_size);

        /// <summary>A plane of 1000 N/m through the origin, without friction. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_patch_default(ref Patch patch, uint struct_size);

        /// <summary>No force. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_wrench_default(ref Wrench wrench, uint struct_size);

        /// <summary>Opens a hand that meets the physics of the program in place of a server's scene. All functions of a hand work with it. The program calls fw_hand_touch() or fw_hand_push() 60 to 1000 times a second; if it stops, the force fades within the hold time. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_open_world(ref WorldOptions options, out IntPtr hand);

        /// <summary>For a hand of fw_hand_open_world(): says which surfaces are within `reach` [m] of the tool, at most 3; 0: none is. `time` [s]: fw_tick.time of the position that the physics used. The hand feels them at its servo rate until the next call, within the hold time. FW_NOTHING: the hand does not take them, because there was no tick yet, `time` is older than the hold time or than that of the last call, or its servo stands still. FW_ENDED: the run has ended. Threads: one thread at a time, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_touch(IntPtr hand, double time, double reach, ref Patch patches, uint struct_size, uint count);

        /// <summary>The same, for physics that knows a force only. With a stiffness the hand feels the plane that has this force at that position. Without one it feels the force as it is, as far as its account pays for it. Prefer fw_hand_touch(): a patch is felt before it pushes. Threads: one thread at a time, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_hand_push(IntPtr hand, ref Wrench wrench);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_observer_options_default(ref ObserverOptions options, uint struct_size);

        /// <summary>Joins a scene as an observer: it has no hand, and sees all hands and moving bodies. Blocks until the server has answered. A thread of the library takes the views. The observer must be closed. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_open(ref ObserverOptions options, out IntPtr observer);

        /// <summary>The newest state. FW_NOTHING: no view has come yet. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_latest(IntPtr observer, ref SceneState state, uint struct_size);

        /// <summary>The hands of the newest state, by rising number, at most `most`. FW_NOTHING: no view has come yet. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_hands(IntPtr observer, ref SeenHand hands, uint struct_size, uint most, out uint count);

        /// <summary>The moving bodies of the newest state, by rising object, at most `most`. FW_NOTHING: no view has come yet. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_bodies(IntPtr observer, ref SeenBody bodies, uint struct_size, uint most, out uint count);

        /// <summary>The name that the client of a hand gives itself. The library asks the server for it when a hand has come. It is cut at `size`, with the zero byte. FW_NOTHING: it is not known yet, or there is no such hand. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_hand_name(IntPtr observer, uint number, byte[] text, uint size);

        /// <summary>Takes the oldest message for people that was not taken yet: the session was lost, or is there again. It is cut at `size`, with the zero byte. FW_NOTHING: there is none. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_message(IntPtr observer, byte[] text, uint size);

        /// <summary>Waits for a state with a greater number, at most `timeout` [s]. FW_OK: it is there; FW_NOTHING: not yet; FW_ENDED: there will be none, and fw_last_error() says why. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_wait(IntPtr observer, ulong number, double timeout);

        /// <summary>Leaves the scene and frees the observer, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had ended it. Null is allowed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_observer_close(IntPtr observer);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_admin_options_default(ref AdminOptions options, uint struct_size);

        /// <summary>Reads the credentials, and asks the server for its scenes, so that an address or a token that is wrong is known at once. Blocks. No connection stays open. The admin must be closed. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_admin_open(ref AdminOptions options, out IntPtr admin);

        /// <summary>Runs a command with the words of `feltwire-client admin` (docs/admin.md): "sessions", or "evict", "3". Blocks until it is done. Sets `answer` to its answer as JSON, which is valid until the next call with this admin; null where the command failed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_admin_request(IntPtr admin, IntPtr words, uint count, out IntPtr answer);

        /// <summary>Frees the admin, which no other call may use meanwhile. Null is allowed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_admin_close(IntPtr admin);

        /// <summary>The name of the state between a hand and a robot, such as "engaged"; empty: there is no such state. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern IntPtr fw_lead_state_text(uint state);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_follower_options_default(ref FollowerOptions options, uint struct_size);

        /// <summary>At the origin, not turned, at rest, well, its force not known. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_robot_state_default(ref RobotState state, uint struct_size);

        /// <summary>Takes a seat for a robot, and runs the follower's loop of feltwire-follower in a thread of its own. Blocks until the server has answered. The follower must be closed. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_open(ref FollowerOptions options, out IntPtr follower);

        /// <summary>Gives the robot's newest state, and returns the newest target, which the robot's controller gets. Call it at the rate of the robot's own loop, 100 to 1000 Hz. A robot that was not heard of for 0.1 s, that is stopped or that has a fault is not led: its target is where it is told to be already. FW_NOTHING: there is no target yet, so the robot stays. FW_ENDED: the run has ended; the robot stays at this target. Threads: one thread at a time, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_exchange(IntPtr follower, ref RobotState state, ref RobotTarget target, uint struct_size);

        /// <summary>The newest target, to watch the robot. FW_NOTHING: there is none yet. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_latest(IntPtr follower, ref RobotTarget target, uint struct_size);

        /// <summary>Takes the oldest message for people that was not taken yet: the seat was lost, or the robot has it again. It is cut at `size`, with the zero byte. FW_NOTHING: there is none. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_message(IntPtr follower, byte[] text, uint size);

        /// <summary>Waits until the run has ended, at most `timeout` [s]. FW_ENDED: it has; FW_NOTHING: not yet. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_wait(IntPtr follower, double timeout);

        /// <summary>Leaves the scene. The target brakes for 0.25 s, then the run ends. Does not wait: call fw_follower_exchange() until FW_ENDED. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_stop(IntPtr follower);

        /// <summary>Ends the run, waits for it, and frees the follower, which no other call may use meanwhile. FW_OK, or FW_ENDED with a text if an error had ended the run. Null is allowed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_follower_close(IntPtr follower);

        /// <summary>Fills in the usual options. Call it first, with sizeof. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern void fw_recorder_options_default(ref RecorderOptions options, uint struct_size);

        /// <summary>Records every tick of a hand from its next tick on, as --record of feltwire-client does. One recording of a hand at a time. A thread of the library writes. The recorder must be closed; the hand may be closed before. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_recorder_open(IntPtr hand, ref RecorderOptions options, out IntPtr recorder);

        /// <summary>Writes a text at this moment into the recording: a metadata record `mark` with `text` and `time` [ns since 1970]. A text that is not UTF-8 is refused. Threads: any thread.</summary>
        [DllImport("feltwire")]
        public static extern int fw_recorder_mark(IntPtr recorder, IntPtr text);

        /// <summary>How far the recording is. Threads: any thread, never waits.</summary>
        [DllImport("feltwire")]
        public static extern int fw_recorder_state(IntPtr recorder, ref RecordingState state, uint struct_size);

        /// <summary>Writes the rest, waits until it is on the disk, and frees the recorder, which no other call may use meanwhile. FW_OK, or FW_ERROR_DEVICE with a text: a file is not complete, or ticks were lost. Null is allowed. Threads: one thread at a time.</summary>
        [DllImport("feltwire")]
        public static extern int fw_recorder_close(IntPtr recorder);
    }
}
