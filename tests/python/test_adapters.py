#!/usr/bin/env python3
"""feltwire.lerobot, feltwire.isaac and feltwire.gym against stand-ins of the interfaces that they fit, which are not installed here.

The stand-ins are written from the published sources, and have what these call:
- LeRobot 0.6.2, commit 7427f318 of github.com/huggingface/lerobot: src/lerobot/teleoperators/teleoperator.py and config.py,
  src/lerobot/utils/import_utils.py (how a plug-in and its class are found), errors.py, src/lerobot/scripts/lerobot_teleoperate.py;
  draccus of github.com/dlwh/draccus: ChoiceRegistry.
- Isaac Lab, github.com/isaac-sim/IsaacLab: source/isaaclab/isaaclab/devices/device_base.py (commit 050b80d2) and haply/se3_haply.py
  (commit 116089fb), whose push_force() has the arguments of ours.
- Gymnasium 1.4.0, commit 3f0476a8 of github.com/Farama-Foundation/Gymnasium: gymnasium/core.py.
"""
import abc
import dataclasses
import importlib
import importlib.metadata
import pathlib
import re
import sys
import tempfile
import types
import unittest

from stand_ins import Tensor, gymnasium, isaac, module
from support import LONGEST, PACKAGE, PATIENT, SOURCE, eventually, run_python
import feltwire
import feltwire.lerobot

# A busy machine may let the program wait, and the force must not fade meanwhile.
WORLD = {**PATIENT, "hold_time": 1}
STIFFNESS = 2000.0  # [N/m]


class StandIns(unittest.TestCase):
    """Modules that are there during a test only. The adapters are loaded anew in each: they keep the classes that they made."""

    def put(self, **modules):
        for name, one in modules.items():
            name = name.replace("__", ".")
            sys.modules[name] = one
            self.addCleanup(sys.modules.pop, name, None)

    def setUp(self):
        for name in ("feltwire.gym", "feltwire.isaac", "lerobot_teleoperator_feltwire", "lerobot_teleoperator_feltwire.feltwire",
                     "lerobot_teleoperator_feltwire.config_feltwire"):
            self.addCleanup(sys.modules.pop, name, None)


def lerobot(folder):
    """LeRobot's modules, with its errors for what a plug-in lacks."""
    class Registry:
        _known = None

        @classmethod
        def register_subclass(cls, name):
            def put(sub):
                if cls._known is None:
                    cls._known = {}
                cls._known[name] = sub
                return sub
            return put

        @classmethod
        def get_choice_name(cls, sub):
            return next(name for name, known in cls._known.items() if known is sub)

    @dataclasses.dataclass(kw_only=True)
    class TeleoperatorConfig(Registry, abc.ABC):
        id: "str | None" = None
        calibration_dir: "pathlib.Path | None" = None

        @property
        def type(self):
            return self.get_choice_name(self.__class__)

    class Teleoperator(abc.ABC):
        def __init__(self, config):
            self.id = config.id
            self.calibration_dir = config.calibration_dir or folder / self.name
            self.calibration_dir.mkdir(parents=True, exist_ok=True)
            self.calibration = {}

        def __str__(self):
            return f"{self.id} {self.__class__.__name__}"

        def __enter__(self):
            self.connect()
            return self

        def __exit__(self, *_):
            self.disconnect()

        def __del__(self):
            try:
                if self.is_connected:
                    self.disconnect()
            except Exception:  # pylint: disable=broad-except
                pass

    for name in ("action_features", "feedback_features", "is_connected", "is_calibrated"):
        setattr(Teleoperator, name, property(abc.abstractmethod(lambda self: None)))
    for name in ("connect", "calibrate", "configure", "get_action", "send_feedback", "disconnect"):
        setattr(Teleoperator, name, abc.abstractmethod(lambda self, *_: None))
    abc.update_abstractmethods(Teleoperator)
    not_connected = type("DeviceNotConnectedError", (ConnectionError,), {})
    already = type("DeviceAlreadyConnectedError", (ConnectionError,), {})
    return {"lerobot": module("lerobot"), "lerobot__utils": module("lerobot.utils"), "lerobot__teleoperators": module("lerobot.teleoperators"),
            "lerobot__teleoperators__config": module("lerobot.teleoperators.config", TeleoperatorConfig=TeleoperatorConfig),
            "lerobot__teleoperators__teleoperator": module("lerobot.teleoperators.teleoperator", Teleoperator=Teleoperator),
            "lerobot__utils__errors": module("lerobot.utils.errors", DeviceNotConnectedError=not_connected, DeviceAlreadyConnectedError=already)}


def register_third_party_plugins():
    """Imports the distributions with LeRobot's prefix."""
    names = {found.metadata.get("Name") for found in importlib.metadata.distributions()}
    return [importlib.import_module(name) for name in names if name and name.startswith("lerobot_teleoperator_")]


def make_device(config):
    """The class beside the configuration's module, by its name without Config."""
    kind = config.__class__
    assert kind.__name__.endswith("Config")
    parent = importlib.import_module(kind.__module__.rsplit(".", 1)[0])
    return getattr(parent, kind.__name__[:-len("Config")])(config)


class LeRobot(StandIns):
    def setUp(self):
        super().setUp()
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.stand_in = lerobot(pathlib.Path(temporary.name))
        self.put(**self.stand_in)
        self.assertIn("lerobot_teleoperator_feltwire", [one.__name__ for one in register_third_party_plugins()])
        self.config = self.stand_in["lerobot__teleoperators__config"].TeleoperatorConfig._known["feltwire"]

    def test_a_scene_is_felt_without_feedback(self):
        with feltwire.serve(SOURCE / "scenes/plane.json") as server:
            config = self.config(id="right", server=server.address, scene="plane", fingerprint_file=server.fingerprint_file,
                                 token_file=server.token_file, options=PATIENT)
            self.assertEqual(config.type, "feltwire")
            hand = make_device(config)
            self.assertEqual(hand.feedback_features, {})
            with hand:
                self.assertTrue(hand.is_connected and hand.is_calibrated)
                action = eventually("the plane is felt", lambda: (now := hand.get_action())["force_z"] > 0.3 and now)
                self.assertEqual(list(action), list(hand.action_features))
                self.assertTrue(all(isinstance(one, float) for one in action.values()))
                self.assertGreater(action["scene_force_z"], 0.3)
                self.assertLess(action["z"], 0.0)
                hand.send_feedback({"force_z": 9.0})  # nothing comes of it
                with self.assertRaises(self.stand_in["lerobot__utils__errors"].DeviceAlreadyConnectedError):
                    hand.connect()
            self.assertFalse(hand.is_connected)
            with self.assertRaises(self.stand_in["lerobot__utils__errors"].DeviceNotConnectedError):
                hand.get_action()

    def test_an_option_that_is_a_field_is_refused_with_the_field(self):
        with self.assertRaisesRegex(ValueError, "'stiffness', which has a field of its own"):
            make_device(self.config(options={**WORLD, "stiffness": 100.0})).connect()

    def test_what_the_limits_and_the_account_take_is_told(self):
        hand = make_device(self.config(stiffness=STIFFNESS, options={**WORLD, "max_force": 1}))
        most = dict.fromkeys(("reduced", "account_cut", "no_force"), 0.0)

        def is_told():
            action = hand.get_action()
            most.update((name, max(value, action[name])) for name, value in most.items())
            hand.send_feedback({"force_z": 50.0})
            self.assertLessEqual(action["force_z"], 1.0 + 1e-9)
            return most["reduced"] == 1.0 and most["account_cut"] > 0.0

        with hand:
            eventually("bound, limits and account are told", is_told)
            self.assertLessEqual(most["account_cut"], 1.0)
            eventually("so is the reason for no force", lambda: hand.get_action()["no_force"] > 0.0)

    def test_a_data_set_has_what_was_felt(self):
        """A data set has one vector of the robot's action features that are numbers, and takes their values by name from each action."""
        hand = make_device(self.config(stiffness=STIFFNESS, options=WORLD))
        features = {"elbow.pos": float, **hand.action_features}  # of a robot's plug-in that names them
        names = [name for name, kind in features.items() if kind is float]
        frames = []

        def recorded():
            action = hand.get_action()
            hand.send_feedback({"force_z": max(0.0, -STIFFNESS * action["z"])})
            frames.append([{**action, "elbow.pos": 0.5}[name] for name in names])
            return frames[-1][names.index("force_z")] > 0.5

        with hand:
            eventually("the feedback is felt", recorded)
        self.assertGreater(len(frames), 1)
        self.assertTrue(all(isinstance(value, float) for frame in frames for value in frame))
        last = dict(zip(names, frames[-1]))
        self.assertLess(last["z"], 0.0)
        self.assertGreater(last["scene_force_z"], 0.5)
        self.assertEqual(names, ["elbow.pos", "x", "y", "z", "qw", "qx", "qy", "qz", "force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z",
                                 "scene_force_x", "scene_force_y", "scene_force_z", "reduced", "account_cut", "no_force"])

    def test_the_command_of_the_page_has_fields_of_the_configuration(self):
        command = re.search(r"^    (lerobot-teleoperate .*)$", (SOURCE / "docs/python.md").read_text(encoding="utf-8"), re.MULTILINE)[1]
        given = dict(re.findall(r"--teleop\.(\w+)=(\S+)", command))
        self.assertEqual(given.pop("type"), "feltwire")
        self.assertEqual(self.config(**given).scene, "bench")

    def test_feedback_is_felt_and_fades(self):
        hand = make_device(self.config(stiffness=STIFFNESS, options=WORLD))
        self.assertEqual(set(hand.feedback_features), {*(f"{what}_{axis}" for what in ("force", "torque") for axis in "xyz"), "stiffness"})
        with hand:
            def pushes():
                action = hand.get_action()
                hand.send_feedback({"force_z": max(0.0, -STIFFNESS * action["z"]), "elbow.pos": 3.0, "camera": None})
                return action["force_z"] > 0.5 and action["scene_force_z"] > 0.5

            eventually("the feedback is felt", pushes)
            action = eventually("it has faded", lambda: (now := hand.get_action())["force_z"] == 0.0 and now)
            self.assertGreater(action["no_force"], 0.0)

    def test_actions_of_the_pose_alone(self):
        hand = make_device(self.config(record_feel=False, options=WORLD))
        self.assertEqual(list(hand.action_features), ["x", "y", "z", "qw", "qx", "qy", "qz"])
        with hand:
            self.assertEqual(list(hand.get_action()), list(hand.action_features))

    def test_a_run_that_has_ended_is_told(self):
        hand = make_device(self.config(options={**WORLD, "duration": 0.2}))
        hand.connect()

        def ended():
            try:
                hand.get_action()
            except feltwire.Error as error:
                return str(error)
            return None

        self.assertIn("connect() joins again", eventually("the run ends", ended))
        self.assertFalse(hand.is_connected)

    def test_a_run_that_ends_before_its_first_tick_is_told(self):
        hand = make_device(self.config(options=WORLD))
        hand.connect()
        run = feltwire.lerobot.hand_of(hand)
        run.stop()
        self.assertTrue(run.wait(LONGEST))
        run.latest = lambda: None
        with self.assertRaisesRegex(feltwire.Error, "has ended"):
            hand.get_action()

    def test_feedback_that_is_no_number_is_named_and_not_felt(self):
        hand = make_device(self.config(options=WORLD))
        with hand:
            for value in (None, "strong", float("nan"), float("inf")):
                for name in ("force_z", "torque_x", "stiffness"):
                    with self.assertRaisesRegex(ValueError, rf"feedback\['{name}'\] must be a finite number"):
                        hand.send_feedback({"force_y": 9.0, name: value})
            eventually("a pose", lambda: hand.get_action() and hand._time is not None)
            with self.assertRaisesRegex(ValueError, "force_z"):
                hand.send_feedback({"force_y": 9.0, "force_z": float("nan")})
            self.assertEqual(hand.get_action()["scene_force_y"], 0.0)

    def test_the_plug_in_has_the_version_of_the_package(self):
        version = re.search(r"project\(feltwire VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        self.assertEqual(importlib.metadata.version("lerobot_teleoperator_feltwire"), version)


class Isaac(StandIns):
    def setUp(self):
        super().setUp()
        self.put(**isaac())

    def make(self, retargeters=None, **options):
        adapter = importlib.import_module("feltwire.isaac")
        return adapter.FeltDevice(adapter.FeltDeviceCfg(stiffness=STIFFNESS, options={**WORLD, **options}), retargeters)

    def test_an_option_that_is_a_field_is_refused_with_the_field(self):
        with self.assertRaisesRegex(ValueError, "'device', which has a field of its own; set device='simulated'"):
            self.make(device="simulated")

    def test_forces_are_felt_and_a_stale_one_fades_to_zero(self):
        device = self.make()
        self.addCleanup(device.close)
        called = []
        for key in ("START", "STOP", "R"):
            device.add_callback(key, lambda key=key: called.append(key))

        def pushes():
            pose = device.advance()
            self.assertEqual(len(pose), 7)
            self.assertAlmostEqual(pose[6], 1.0, places=6)  # w is last
            device.push_force(Tensor([[9.0, 9.0, 9.0], [0.0, 0.0, max(0.0, -STIFFNESS * pose[2])]]), Tensor([1]))
            return device.hand.latest() is not None and device.hand.latest().force[2] > 0.5

        eventually("the force is felt", pushes)
        self.assertEqual(called, ["START"])
        eventually("nobody pushes: the force has faded to zero", lambda: device.hand.latest().force[2] == 0.0)
        with self.assertRaisesRegex(ValueError, "no forces"):
            device.push_force(Tensor())
        forces = Tensor([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]])
        pushed = []
        device.hand.push = lambda force, *_, **__: pushed.append(force) or True
        for position in (Tensor([2, 0]), Tensor([-1, 0]), Tensor([True, False, True]), (0, 2)):
            self.assertTrue(device.push_force(forces, position))
            self.assertEqual(pushed.pop(), [1.0, 0.0, 4.0], position)
        device.push_force(forces, 1)
        self.assertEqual(pushed.pop(), [0.0, 2.0, 0.0])
        for none in (Tensor([False] * 3), Tensor()):
            device.push_force(forces, none)
            self.assertEqual(pushed.pop(), [0.0, 0.0, 0.0])
        for wrong, named in ((Tensor([True, False]), "a mask of 2 truth values for 3"), (Tensor([3]), "position has 3"),
                             (Tensor([-4]), "position has -4"), (Tensor([0.0]), "position has 0.0"), (Tensor([1, True]), "position has True")):
            with self.assertRaisesRegex(ValueError, named):
                device.push_force(forces, wrong)
        self.assertEqual(pushed, [])
        del device.hand.push
        device.hand.stop()
        eventually("the run ends", lambda: device.advance() is not None and "STOP" in called)
        self.assertFalse(device.push_force(Tensor([[0.0, 0.0, 1.0]])))
        self.assertEqual(called, ["START", "STOP"])

    def test_reset_takes_the_force_off(self):
        device = self.make()
        self.addCleanup(device.close)

        def pushes():
            pose = device.advance()
            device.push_force(Tensor([[0.0, 0.0, max(0.0, -STIFFNESS * pose[2])]]))
            return device.hand.latest() is not None and device.hand.latest().force[2] > 0.5

        eventually("the force is felt", pushes)
        device.reset()
        eventually("the scene commands nothing", lambda: tuple(device.hand.latest().scene_force) == (0.0, 0.0, 0.0))

    def test_retargeters_get_the_pose(self):
        retargeter = types.SimpleNamespace(retarget=lambda pose: Tensor([2.0 * pose[2]]))
        device = self.make([retargeter, retargeter])
        self.addCleanup(device.close)
        self.assertEqual(len(device.advance()), 2)


class Gymnasium(StandIns):
    def setUp(self):
        super().setUp()
        self.put(**gymnasium())
        self.table = sys.modules["gymnasium"].make("Table-v0")

    def wrap(self, contacts, **options):
        gym = importlib.import_module("feltwire.gym")
        env = gym.FeltEnv(self.table, contacts, stiffness=STIFFNESS, **{**WORLD, **options})
        self.addCleanup(env.hand.close)
        return env

    def felt(self, env):
        return eventually("the table is felt", lambda: (info := env.step(0.0)[4])["feltwire"].get("force", (0, 0, 0))[2] > 0.5 and info)

    def test_patches_are_felt(self):
        seen = []

        def contacts(table, position):
            seen.append(table)
            return [feltwire.Patch((position[0], position[1], 0.0), (0, 0, 1), STIFFNESS)]

        env = self.wrap(contacts, act=lambda action, tick: None if tick is None else tick.position[2])
        observation, info = env.reset(seed=3, options={"a": 1})
        self.assertEqual((observation, info["options"]), (3, {"a": 1}))
        info = self.felt(env)
        self.assertGreater(info["steps"], 0)
        self.assertTrue(info["feltwire"]["taken"])
        self.assertLess(env.step(0.0)[0], 0.0)  # the action is the height of the hand
        self.assertIs(seen[0], self.table)
        env.reset()
        eventually("reset() takes the table away", lambda: env.hand.latest().scene_force[2] == 0.0)
        env.close()
        self.assertTrue(self.table.closed)

    def test_a_wrench_is_felt_and_fades_when_nobody_steps(self):
        gym = importlib.import_module("feltwire.gym")
        env = self.wrap(lambda table, position: gym.Wrench((0, 0, max(0.0, -STIFFNESS * position[2])), STIFFNESS))
        self.felt(env)
        eventually("the force has faded", lambda: env.hand.latest().force[2] == 0.0)


    def test_a_run_that_ends_truncates_the_episode(self):
        env = self.wrap(lambda table, position: [])
        env.reset()
        self.assertEqual(env.step(0.0)[2:4], (False, False))
        env.hand.stop()
        self.assertTrue(env.hand.wait(LONGEST))
        *_, terminated, truncated, info = env.step(0.0)
        self.assertEqual((terminated, truncated, info["feltwire"]["ended"], info["feltwire"]["taken"]), (False, True, True, False))
        steps = self.table.steps
        for call in (lambda: env.step(0.0), env.reset):
            with self.assertRaisesRegex(feltwire.Error, "the hand's run has ended"):
                call()
        self.assertEqual(self.table.steps, steps)
        env.close()
        self.assertTrue(self.table.closed)


class Absent(unittest.TestCase):
    def test_nothing_is_imported_and_what_is_missing_is_named(self):
        said = run_python("""
import sys
import feltwire.gym, feltwire.isaac, feltwire.lerobot
print(sorted(name for name in ("gymnasium", "isaaclab", "torch", "lerobot", "numpy") if name in sys.modules))
for name, get in (("gym", lambda: feltwire.gym.FeltEnv), ("isaac", lambda: feltwire.isaac.FeltDevice)):
    sys.modules.update(dict.fromkeys(("gymnasium", "isaaclab"), None))
    try:
        get()
    except feltwire.Error as error:
        print(name, error)
""")
        lines = said.splitlines()
        self.assertEqual(lines[0], "[]")
        self.assertIn("needs the Python package gymnasium; install it", lines[1])
        self.assertIn("needs Isaac Lab", lines[2])

    def test_the_package_has_the_plug_in_beside_it(self):
        self.assertTrue((PACKAGE / "lerobot_teleoperator_feltwire.egg-info/PKG-INFO").exists())


if __name__ == "__main__":
    unittest.main()
