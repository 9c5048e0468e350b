#!/usr/bin/env python3
"""Scenes that a program writes, the laboratory's verbs, servers of several scenes, and the live page."""
import contextlib
import io
import json
import pathlib
import tempfile
import unittest
import unittest.mock
import urllib.request

from support import PATIENT, SOURCE, eventually, numpy
import feltwire
from feltwire.options import words
from feltwire.scenes import turned

PLANE = SOURCE / "scenes/plane.json"


def kitchen():
    scene = feltwire.Scene("kitchen", description="A table with things.")
    scene.material("steel", 1500, static_friction=0.2, dynamic_friction=0.15)
    scene.plane("table", material="steel")
    scene.sphere("knob", 0.02, position=(0, 0, 0.02), material="steel")
    return scene


def forces(scene, *positions, **options):
    """The elastic force [N] at each position [m]."""
    rows = [{"t": 0.1 * i, "x": x, "y": y, "z": z} for i, (x, y, z) in enumerate(positions)]
    return [[float(one) for one in row] for row in feltwire.lab.touch(scene=scene, table=rows, **options).table["elastic"]]


class Scenes(unittest.TestCase):
    def test_every_shape_is_taken_by_the_server(self):
        scene = kitchen()
        scene.box("box", (0.01, 0.02, 0.03), position=(0.1, 0, 0), orientation=turned((0, 0, 1), 30), material="steel")
        scene.capsule("capsule", 0.01, 0.02, position=(0.2, 0, 0), material="steel")
        scene.cylinder("cylinder", 0.01, 0.02, position=(0.3, 0, 0), material="steel")
        scene.cone("cone", 0.01, 0.02, position=(0.4, 0, 0), material="steel")
        scene.torus("torus", 0.02, 0.005, position=(0.5, 0, 0), material="steel")
        scene.object("hollow", {"box": {"size": [2, 2, 2]}}, felt_from="inside", material="steel")
        scene.folder = SOURCE / "scenes"
        scene.mesh("bunny", "bunny.obj", scale=0.01, position=(0.7, 0, 0), material="steel", mesh={"smooth": True})
        scene.body("button", 0.02, position=(-0.07, 0.05, 0.006), joint="slide", axis=[0, 0, 1], range=[-0.004, 0], stiffness=300,
                   rest=0.002, damping=1, collides=False)
        scene.cylinder("button", 0.012, 0.012, body="button", material="steel")
        scene.guide("rail", {"line": {"length": 0.1}}, {"attract": {"stiffness": 250, "range": 0.015}}, max_force=1.5)
        scene.tool("tip")
        scene.tool("finger", sphere={"radius": 0.006})
        said = scene.check()
        self.assertIn("scene kitchen: 10 objects, 1 guide,", said.text)
        self.assertIn("finger (a ball of 0.006 m)", said.text)

    def test_the_server_names_the_place_of_an_error(self):
        scene = kitchen()
        scene.data["objects"][1]["sphere"]["radius"] = -0.02
        with self.assertRaisesRegex(feltwire.SceneError, r"^kitchen.json:9: objects\[1\].sphere.radius: must be above zero"):
            scene.check()
        self.assertIn("-0.02", scene.text().splitlines()[8])
        with self.assertRaisesRegex(feltwire.Error, "objects.1..sphere.radius"):
            feltwire.serve(scene)
        scene.data["objects"][1]["sphere"]["radius"] = float("nan")
        with self.assertRaises(ValueError):
            scene.text()

    def test_a_scene_feels_as_it_says(self):
        scene = kitchen()
        self.assertEqual(forces(scene, (0.1, 0, 0.001), (0.1, 0, -0.002)), [[0, 0, 0], [0, 0, 3.0]])
        with tempfile.TemporaryDirectory() as folder:
            path = scene.save(pathlib.Path(folder) / "kitchen.json")
            self.assertEqual(json.loads(path.read_text()), json.loads(scene.text()))
            again = feltwire.Scene.load(path)
        again.data["materials"][0]["stiffness"] = 500
        self.assertEqual(forces(again, (0.1, 0, -0.002)), [[0, 0, 1.0]])

    def test_every_scene_of_the_repository_is_loaded_with_its_comments(self):
        for path in sorted((SOURCE / "scenes").glob("**/*.json")):
            scene = feltwire.Scene.load(path)
            self.assertTrue(scene.name, path)
        self.assertEqual(forces(feltwire.Scene.load(SOURCE / "scenes/room.json"), (0, 0, -0.052)), forces(SOURCE / "scenes/room.json", (0, 0, -0.052)))
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "broken.json"
            path.write_text('{\n  "name": "x",\n  "objects": [}\n')
            with self.assertRaisesRegex(feltwire.SceneError, r"broken.json:3: "):
                feltwire.Scene.load(path)
            path.write_text('{ name: "a // b, ]", /* , */ list: [1, 2, // ]\n ], }')
            self.assertEqual(feltwire.Scene.load(path).data, {"name": "a // b, ]", "list": [1, 2]})

    @unittest.skipUnless(numpy, "NumPy is not installed")
    def test_arrays_are_numbers(self):
        scene = kitchen()
        scene.box("box", numpy.array([0.01, 0.02, 0.03]), position=numpy.zeros(3), material="steel")
        self.assertEqual(json.loads(scene.text())["objects"][2]["box"]["size"], [0.01, 0.02, 0.03])


class Laboratory(unittest.TestCase):
    def test_a_filter(self):
        command = {name: [0.0] for name in ("dx", "dy", "dz", "ex", "ey", "ez", "fx", "fy", "fz")}
        command.update(ey=[4.0], dy=[-1e-4])
        result = feltwire.lab.bound(period=0.001, damping=0.5, mode="none", table=command)
        self.assertEqual([list(map(float, row)) for row in result.table["held"]], [[0, 4, 0]])
        if numpy:
            array = numpy.zeros(1, dtype=[(name, float) for name in command])
            array["ey"] = 4.0
            self.assertEqual(float(feltwire.lab.bound(period=0.001, damping=0.5, mode="none", table=array).table["held"][0, 1]), 4.0)

    def test_a_study_is_parsed(self):
        result = feltwire.lab.run("extremes", hands=1)
        table = result.tables["extremes"]
        self.assertEqual(table.fields[:2], ["stress", "method"])
        self.assertTrue(all(float(one) == 1.0 for one in table["passed"]))
        self.assertEqual(result.documents["extremes"][0]["double"]["passed"], True)
        self.assertIn("worst energy missing", result.text)

    def test_errors(self):
        with self.assertRaisesRegex(feltwire.Error, "no_scene.json: cannot be opened"):
            feltwire.lab.touch(scene="no_scene.json", table={"t": [0]})
        self.assertNotEqual(feltwire.lab.touch(scene="no_scene.json", table={"t": [0]}, check=False).status, 0)
        with self.assertRaisesRegex(AttributeError, "no verb tuch"):
            feltwire.lab.tuch
        with self.assertRaisesRegex(ValueError, "different lengths"):
            feltwire.lab.touch(scene=PLANE, table={"t": [0], "x": [0, 1]})
        self.assertIn("where_to_bound", dir(feltwire.lab))
        self.assertIn("Filter", feltwire.lab.verbs()["touch"])


class Servers(unittest.TestCase):
    def test_several_scenes(self):
        with feltwire.serve([PLANE, kitchen(), SOURCE / "scenes/room.json"]) as server:
            self.assertEqual(server.scenes, ["plane", "kitchen", "room"])
            for scene in (None, "kitchen", "room"):
                with server.join(scene, **PATIENT) as hand:
                    eventually("a tick", hand.latest)
                    self.assertAlmostEqual(hand.session.stiffness, {None: 600, "kitchen": 1500, "room": 1500}[scene])

    def test_words_of_options(self):
        self.assertEqual(words({"real_time": True, "web_name": ["a", "b"], "record": None, "log_level": "debug", "x": False}, repeat=True),
                         ["--real-time", "--web-name", "a", "--web-name", "b", "--log-level", "debug"])

    def test_the_live_page_is_opened_without_the_token_in_a_command(self):
        said, opened = io.StringIO(), []
        with contextlib.redirect_stdout(said), unittest.mock.patch("webbrowser.open", opened.append):
            server = feltwire.play(PLANE)
        with server:
            token = pathlib.Path(server.token_file).read_text().strip()
            self.assertEqual(server.link, f"{server.page}#token={token}")
            self.assertEqual(said.getvalue(), f"live page: {server.page}\n")
            (door,) = opened
            path = pathlib.Path(door.removeprefix("file://"))
            self.assertIn(server.link, path.read_text())
            self.assertEqual(path.stat().st_mode & 0o777, 0o600)
            with urllib.request.urlopen(server.page, timeout=60) as page:
                self.assertEqual(page.status, 200)
        self.assertFalse(path.exists())
        with feltwire.serve(PLANE) as server, self.assertRaisesRegex(ValueError, "no live page"):
            server.link


if __name__ == "__main__":
    unittest.main()
