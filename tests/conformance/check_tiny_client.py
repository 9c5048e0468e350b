#!/usr/bin/env python3
"""Checks examples/tiny_client.py: its length, its forces at feltwire-server, what it refuses, and that its force fades.

usage: check_tiny_client.py BIN_FOLDER
"""
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import patience  # noqa: E402
from model_server import ModelServer  # noqa: E402
from server_process import SOURCE, Server  # noqa: E402

PROGRAM = SOURCE / "examples/tiny_client.py"
LINE = re.compile(r"(-?[\d.]+) mm deep: ([\d.]+) N")
STIFFNESS = 600.0  # [N/m] of scenes/plane.json and of the model server's plane
HOLD = 0.1  # [s] of the client
LONGEST = patience.LONGEST + 20  # [s]


class TinyClient(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def run_at(self, server, seconds, fingerprint=None, token=None, scene="plane"):
        """(exit status, stdout, stderr)."""
        file = Path(self.folder.name) / "token"
        file.write_text((token or server.token("operator")) + "\n", encoding="ascii")
        words = [sys.executable, "-B", PROGRAM, f"127.0.0.1:{server.port}", scene, fingerprint or server.fingerprint, file, seconds]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=LONGEST, check=False)
        return done.returncode, done.stdout, done.stderr

    def refused_at(self, server, said, **more):
        status, out, error = self.run_at(server, 5, **more)
        self.assertEqual((status, out), (1, ""), error)
        self.assertRegex(error, said)

    def model(self, *arguments, **more):
        server = ModelServer(*arguments, roles=("operator",), **more)
        self.addCleanup(server.close)
        return server

    def test_is_short(self):
        self.assertLess(len(PROGRAM.read_text(encoding="utf-8").splitlines()), 150)

    def test_feels_a_wall_as_stiff_as_it_is(self):
        server = Server(Path(sys.argv[1]) / "feltwire-server")
        self.addCleanup(server.close)
        status, out, error = self.run_at(server, 2.5)
        self.assertEqual((status, error), (0, ""))
        felt = [(float(depth) / 1000, float(force)) for depth, force in LINE.findall(out)]
        self.assertEqual(len(felt), len(out.splitlines()))
        self.assertTrue([depth for depth, _ in felt if depth > 0.005], f"the wall was not pressed: {out}")
        self.assertTrue([depth for depth, _ in felt if depth < 0], f"the wall was not left: {out}")
        # On the way in the surface is felt as stiff as it is; on the way out the server's bound gives less, and never more.
        rising = [(depth, force) for (last, _), (depth, force) in zip(felt, felt[1:]) if last < depth < 0.009]
        self.assertGreater(len(rising), 5)
        for depth, force in rising:
            self.assertAlmostEqual(force, STIFFNESS * max(0.0, depth), delta=1e-3)
        for depth, force in felt:
            self.assertLess(force, STIFFNESS * max(0.0, depth) + 1e-3)
        self.refused_at(server, "fingerprint", fingerprint="0" * 64)
        self.refused_at(server, "refused: .*token", token="fw_0123456789ab_" + "0" * 64)
        self.refused_at(server, "refused: .*no such scene", scene="no such scene")

    def test_refuses_other_versions_and_secrets(self):
        server = self.model()
        server.versions = {}  # as programs of version 1
        self.refused_at(server, "the server speaks version 1 of the protocol, this client version 2")
        self.refused_at(self.model(["secret_short"]), "no good secrets")
        self.refused_at(self.model(["secrets_equal"]), "no good secrets")

    def test_takes_no_forged_reply(self):
        server = self.model(["wrong_secret"], silence=1.0)
        self.refused_at(server, "no answer for 1.0 s")

    def test_lets_its_force_fade_without_answers(self):
        server = self.model(silence=1.0)
        last = []

        def answer(session, table):
            if len(last) < 100:
                last.append(table.samples[0].client_time)
                return {"force": (0.0, 0.0, 5.0)}
            return []
        server.answer = answer
        status, _, error = self.run_at(server, 20)
        self.assertEqual(status, 1)
        self.assertIn("no answer for 1.0 s", error)
        held = [(table.samples[0].client_time, table.samples[0].held_elastic.z) for _, _, _, table, _ in server.datagrams]
        self.assertTrue([force for _, force in held if force == 5.0])
        # The last answer came after its sample was read, and not later than the first sample that holds less.
        faded = [(time, force) for time, force in held if time > last[-1] and force < 5.0]
        self.assertTrue(faded)
        self.assertGreaterEqual(faded[0][0] - last[-1], 0.5 * HOLD * 1e9)
        fell = [force for _, force in faded]
        self.assertEqual(fell, sorted(fell, reverse=True))
        arrived = faded[0][0] - 0.5 * HOLD * 1e9
        self.assertTrue(all(force == 0.0 for time, force in faded if time > arrived + HOLD * 1e9))
        self.assertEqual(fell[-1], 0.0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
