#!/usr/bin/env python3
"""Bounding laws in Python and in C, judged by the laboratory as the built-in ones."""
import math
import pathlib
import runpy
import subprocess
import tempfile
import unittest

from support import SOURCE
import feltwire
from feltwire import lab, laws
from feltwire.library import program

EXAMPLES = pathlib.Path(program("feltwire-lab")).resolve().parent.parent / "examples"  # of the build
EnergyStore = runpy.run_path(str(SOURCE / "examples/python/own_law.py"))["EnergyStore"]
QUICK = {"tasks": "tap"}  # the shortest one


class PerAxis:
    """The built-in method per_axis (core/bounding/per_axis.hpp), for forces without torque."""

    name = "my_per_axis"
    promise = "port_by_axis"

    def __init__(self, device):
        self.constant = [device.damping[i][i] / device.period for i in range(3)]
        self.held = (0.0, 0.0, 0.0)

    @staticmethod
    def axis(command, dx, held, c):
        """Signs as in the paper: F = -f."""
        a = c * dx
        h = math.sqrt(a * a + held * held)
        other = abs(held) * (abs(held) / (h + abs(a))) if h + abs(a) > 0.0 else 0.0
        high, low = (a + h if a >= 0 else other), (a - h if a <= 0 else -other)
        if dx > 0:
            high = min(high, held + c * dx)
        if dx < 0:
            low = max(low, held + c * dx)
        return max(low, min(high, command))

    def step(self, step):
        self.held = tuple(-self.axis(-f, dx, -held, c) for f, dx, held, c in zip(step.force, step.displacement, self.held, self.constant))
        return self.held

    def set_held(self, held):
        self.held = tuple(a + b for a, b in zip(held[0], held[1]))


def rows(result, law):
    return [row for row in result.documents["compare"]["rows"] if row["method"] == law]


class Compared(unittest.TestCase):
    def assert_equal_rows(self, some, others):
        self.assertTrue(some)
        self.assertEqual(len(some), len(others))
        for one, other in zip(some, others):
            for column in ("oscillation_um", "direction_error_deg", "displayed", "energy_made_mj"):
                self.assertAlmostEqual(one[column], other[column], delta=1e-12 * max(1.0, abs(other[column])), msg=column)

    def test_a_law_written_again_in_python_gives_the_figures_of_the_built_in_one(self):
        result = lab.compare(PerAxis, methods=["per_axis", "none"], **QUICK)
        self.assert_equal_rows(rows(result, "my_per_axis"), rows(result, "per_axis"))
        self.assertNotEqual(rows(result, "per_axis")[0]["displayed"], rows(result, "none")[0]["displayed"])

    def test_a_law_in_c_gives_the_figures_of_the_same_law_in_python(self):
        with tempfile.TemporaryDirectory() as out:
            in_c = lab.run("compare", law=EXAMPLES / "my_law.so", out=out, **QUICK)
        result = lab.compare(EnergyStore, **QUICK)
        self.assert_equal_rows(rows(result, "energy_store"), rows(in_c, "my_law"))

    def test_an_empty_list_is_named(self):
        for name in ("methods", "tasks"):
            with self.assertRaisesRegex(ValueError, f"{name} is an empty list"):
                lab.compare(EnergyStore, **{**QUICK, name: []})
        with self.assertRaisesRegex(ValueError, "methods is an empty list"):
            lab.extremes(EnergyStore, methods=())
        with self.assertRaisesRegex(ValueError, "damping is an empty list"):
            lab.run("bound", damping=[])
        for table in ([], {}):
            with self.assertRaisesRegex(ValueError, "the table has no columns"):
                lab.bound(table=table)

    def test_the_table(self):
        result = lab.compare(EnergyStore, methods=["none"], **QUICK)
        table = result.table
        self.assertEqual(table.fields, ["task", "law", "energy_made", "stiffness_shown", "swing", "direction_error", "cost"])
        self.assertEqual(list(table["law"]), ["reference", "none", "energy_store"])
        self.assertEqual(set(table["task"]), {"tap"})
        self.assertEqual(table["energy_made"][2], 0.0)
        self.assertGreater(table["cost"][2], table["cost"][1])
        self.assertNotIn("Tables are in", result.text)
        self.assertRegex(repr(result), r"task +method [^\0]*\n +energy_store ")
        self.assertEqual(lab.compare(EnergyStore, **QUICK).table["law"][:3], ["reference", "none", "contact_frame"])

    def test_the_units_of_the_table(self):
        result = lab.compare(tasks=["stick_slip"], methods=["none", "per_axis"], damping=2, delay=5)  # one swings, one bends the force
        for row, law in enumerate(result.table["law"]):
            (given,) = rows(result, law)
            for column, other, unit in (("energy_made", "energy_made_mj", 1e-3), ("swing", "oscillation_um", 1e-6), ("stiffness_shown", "displayed", 1.0),
                                        ("direction_error", "direction_error_deg", math.pi / 180.0)):
                self.assertAlmostEqual(result.table[column][row], unit * given[other], delta=1e-5 * unit * max(1.0, given[other]), msg=(law, column))
            self.assertTrue(1e-9 < result.table["cost"][row] < 1e-3)
        self.assertGreater(result.table["energy_made"][1], 0.01)
        self.assertGreater(result.table["swing"][1], 1e-5)
        self.assertGreater(result.table["direction_error"][2], 0.1)

    def test_an_object_and_a_function_are_laws_too(self):
        class Counting:
            name = "counting"
            resets = 0

            def reset(self, device):
                self.steps = 0
                assert device.period > 0.0 and device.damping[1][0] == 0.0

            def step(self, step):
                self.steps += 1
                return step.elastic, step.frictional, step.torque

        def all_of_it(step):
            return step.elastic, step.frictional, step.torque

        one = Counting()
        result = lab.compare(one, all_of_it, methods="none", **QUICK)
        self.assert_equal_rows(rows(result, "counting"), rows(result, "none"))
        self.assert_equal_rows(rows(result, "all_of_it"), rows(result, "none"))
        self.assertFalse(hasattr(one, "steps"))  # each run has a copy


class Judged(unittest.TestCase):
    def test_the_right_sign_passes_and_the_wrong_one_is_found(self):
        result = lab.extremes(EnergyStore, hands=1)
        self.assertEqual(set(result.tables["extremes"]["method"]), {"energy_store"})
        self.assertTrue(all(result.tables["extremes"]["passed"]))

        class Wrong(EnergyStore):
            sign = -1.0

        with self.assertRaises(lab.LawFailed) as failed:
            lab.extremes(Wrong, hands=1)
        self.assertIn("FAILED  an ordinary hand, wrong, double", str(failed.exception))
        self.assertEqual({row["method"] for row in failed.exception.rows}, {"wrong"})
        self.assertGreater(failed.exception.rows[0]["energy_error"], 1e-3)

    def test_a_law_in_c(self):
        for law, status in (("my_law", 0), ("my_law_wrong", 1)):
            done = lab.run("extremes", law=EXAMPLES / f"{law}.so", hands=1, check=False)
            self.assertEqual((done.status, done.said), (status, ""), done.text)
            self.assertEqual("FAILED" in done.text, bool(status))

    def test_what_is_no_law_in_c_is_refused(self):
        for file, words in (("none.so", "there is no such file; give the path"), ("my_plugin.so", r"exports no function feltwire_law\(\); declare"),
                            ("my_law.so,", "cannot be loaded|no such file")):
            with self.assertRaisesRegex(feltwire.Error, words):
                lab.run("extremes", law=EXAMPLES / file)
        with tempfile.TemporaryDirectory() as folder:
            odd = pathlib.Path(folder) / "odd.so"
            text = (SOURCE / "examples/my_law.c").read_text(encoding="utf-8").replace("FELTWIRE_KEPT_ALL,", "77,")
            text = text.replace("<feltwire/", f"<{SOURCE}/")
            subprocess.run(["cc", "-std=c99", "-shared", "-fPIC", "-x", "c", "-", "-o", odd, "-lm"], input=text, text=True, check=True)
            with self.assertRaisesRegex(feltwire.Error, "kept_despite is 77; add up FELTWIRE_KEPT_"):
                lab.run("extremes", law=odd, hands=1)
        twice = subprocess.run([program("feltwire-lab"), "extremes", *2 * ["--law", str(EXAMPLES / "my_law.so")]], capture_output=True, text=True,
                               check=False)
        self.assertIn("bounding method 'my_law': there is one of that name; take another", twice.stderr)


class Frontier(unittest.TestCase):
    def test_the_drawn_plants_take_no_other_plant(self):
        for option in ({"told": True}, {"plant": "plant.json"}):
            with self.assertRaisesRegex(feltwire.Error, "--judged excludes|excludes --judged"):
                lab.run("frontier", judged=True, hands=0, **option)


class Wrong(unittest.TestCase):
    def assert_fails(self, words, step, after=None):
        calls = []

        class Faulty:
            def __init__(self, device):
                pass

            def step(self, now):
                calls.append(now)
                return step(now) if len(calls) >= 5 else (0.0, 0.0, 0.0)

        if after is not None:
            Faulty.set_held = lambda self, held: after(held)
        for judge, options in ((lab.compare, QUICK), (lab.extremes, {"hands": 1})):
            calls.clear()
            with self.assertRaisesRegex(feltwire.Error, words) as raised:
                judge(Faulty, **options)
        return raised.exception

    def test_a_law_that_raises_is_named_with_its_step(self):
        error = self.assert_fails("^law faulty: step [1-9][0-9]*: it raised ZeroDivisionError: division by zero; __cause__ is", lambda step: 1 / 0)
        self.assertIsInstance(error, lab.LawError)
        self.assertIsInstance(error.__cause__, ZeroDivisionError)

    def test_what_is_no_force_is_named_with_its_step(self):
        for given, words in ((None, "None"), ((1.0, 2.0), r"\(1.0, 2.0\)"), (3.0, "3.0"), ((1.0, "a", 2.0), "'a'"), (((0, 0), (0, 0), (0, 0)), r"\(0, 0\)")):
            self.assert_fails(rf"^law faulty: step [1-9]\d*: step\(\) returned .*{words}.*; return the force as 3 numbers", lambda step, given=given: given)

    def test_not_a_number_is_named_with_its_step(self):
        for bad in (math.nan, math.inf):
            self.assert_fails(rf"law faulty: step [1-9]\d*: rendered the force \(0, {bad}, 0\) N .*; return finite numbers", lambda step, bad=bad: (0.0, bad, 0.0))

    def test_a_constructor_that_raises(self):
        class Picky:
            def __init__(self, device):
                raise ValueError("too little damping")

            def step(self, step):
                return step.force

        with self.assertRaisesRegex(lab.LawError, "^law picky: step 0: it raised ValueError: too little damping"):
            lab.compare(Picky, **QUICK)

    def test_wrong_entries(self):
        class Named(EnergyStore):
            name = "Mine!"

        class Promising(EnergyStore):
            promise = "coupling"

        class Keeping(EnergyStore):
            kept_despite = "reductions"

        class Built(EnergyStore):
            name = "contact_frame"

        for laws, words in (([3], "3 is no law"), ([int], "class int has no step"), ([Named], "'Mine!' of a law is not 1 to 64"),
                            ([EnergyStore, EnergyStore], "two laws have the same name"), ([Promising], "promise 'coupling' is not one of none, port"),
                            ([Keeping], "kept_despite is not a list of")):
            with self.assertRaisesRegex(ValueError, words):
                lab.compare(*laws, **QUICK)
        with self.assertRaisesRegex(feltwire.Error, "'contact_frame': there is one of that name; take another"):
            lab.compare(Built, **QUICK)
        with self.assertRaisesRegex(ValueError, "takes laws, or a scene"):
            lab.compare(EnergyStore, scene="plane.json")
        with self.assertRaisesRegex(feltwire.Error, "unknown task 'tab'; choose one of: wall"):
            lab.compare(EnergyStore, tasks="tab")

    def test_entries_of_other_types_and_names_of_the_table(self):
        for entries, words in (({"promise": ["port"]}, "promise .* is not one of none, port"), ({"kept_despite": None}, "kept_despite is not a list"),
                               ({"kept_despite": [["reductions"]]}, "kept_despite is not a list")):
            with self.assertRaisesRegex(ValueError, words):
                lab.compare(type("Mine", (EnergyStore,), entries), **QUICK)
        with self.assertRaisesRegex(feltwire.Error, "'reference': the tables have the surface itself under this name; take another"):
            lab.compare(type("Mine", (EnergyStore,), {"name": "reference"}), **QUICK)
        twice = type("Mine", (EnergyStore,), {"kept_despite": ["overlong_holds", "overlong_holds"]})
        once = type("Mine", (EnergyStore,), {"kept_despite": ["overlong_holds"]})
        self.assertEqual(laws._Law(twice).description, laws._Law(once).description)

    def test_an_error_without_words_is_named_too(self):
        class Mute(Exception):
            def __str__(self):
                raise RuntimeError("no words")

        def mute(step):
            raise Mute

        with self.assertRaisesRegex(lab.LawError, "^law mute: step 1: it raised Mute"):
            lab.compare(mute, **QUICK)

    def test_a_laboratory_that_has_ended_before_it_was_asked(self):
        server = laws.LawServer([EnergyStore])
        self.addCleanup(server.close)
        server.serve()  # there is no child

    def test_a_timeout(self):
        with self.assertRaises(subprocess.TimeoutExpired):
            lab.extremes(EnergyStore, timeout=0.05)


if __name__ == "__main__":
    unittest.main()
