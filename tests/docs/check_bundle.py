#!/usr/bin/env python3
"""feltwire-bundle packs what helps after an incident, and no secret that stands in the server's files or its log.

A real server runs with a state folder of its own, flight records, and a log with secrets that are planted there and in its configuration.

usage: check_bundle.py BIN_FOLDER SOURCE_FOLDER
"""

import json
import pathlib
import stat
import subprocess
import sys
import tarfile
import tempfile
import unittest

PROGRAMS, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
PASSWORD = "correct-horse-battery"


class Bundle(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.state, self.log = self.folder / "state", self.folder / "server.log"
        self.flights = self.folder / "flights"
        self.flights.mkdir()
        self.out = self.folder / "out.tar.gz"
        (self.flights / "room-1.mcap").write_bytes(b"inputs of a hand")
        self.config, self.defaults = self.folder / "server.json", self.folder / "defaults"
        self.config.write_text(json.dumps({"scenes": [str(SOURCE / "scenes/room.json")], "port": 0, "metrics": "0"}))
        with self.log.open("w") as log:
            server = self.enterContext(subprocess.Popen([PROGRAMS / "feltwire-server", "--config", self.config, "--state", self.state],
                                                        stdout=subprocess.PIPE, stderr=log, text=True))
            self.addCleanup(server.terminate)
        for line in server.stdout:
            with self.log.open("a") as log:
                log.write(line)
            if line.startswith("metrics: "):
                break
        self.token = (self.state / "local.token").read_text().strip()
        self.key = (self.state / "key.pem").read_text()
        self.secrets = [self.token, self.token.split("_", 2)[2], PASSWORD,
                        *(line for line in self.key.splitlines() if not line.startswith("---"))]

    def bundle(self, expect=0):
        out = self.out
        done = subprocess.run([PROGRAMS / "feltwire-bundle", out.name, "--config", self.config, "--defaults", self.defaults, "--state", self.state, "--flights",
                               self.flights, "--log", self.log], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              check=False)
        self.assertEqual(done.returncode, expect, done.stdout)
        return out, done.stdout

    def members(self, out):
        with tarfile.open(out) as archive:
            return {pathlib.PurePath(member.name).name: archive.extractfile(member).read().decode() for member in archive if member.isfile()}

    def test_what_is_in_it_and_what_is_not(self):
        planted = (f"live page: http://127.0.0.1:1/#token={self.token}\nGET /foxglove?ticket={PASSWORD}\n{self.key}\n"
                   f"Authorization: Bearer {PASSWORD}\npassword={PASSWORD}\nhttps://anna:{PASSWORD}@lab.example/\n"
                   f"https://{PASSWORD}@lab.example/ GET /x?api_key={PASSWORD} bearer\t{PASSWORD} %22token%22:%22{PASSWORD}\nCookie: {PASSWORD}\n")
        self.log.write_text(planted + self.log.read_text())
        self.config.write_text(json.dumps({"scenes": [str(SOURCE / "scenes/room.json")], "record": self.token, "key": self.key, "token": PASSWORD,
                                           "tokens": "/etc/tokens.json", "web_names": [self.token], "pass": "/" + PASSWORD, "port": 6720,
                                           "api": {"value": PASSWORD}, "more": [PASSWORD, "a\"" + PASSWORD]}, indent=1).replace('": "', '":\n "'))
        self.defaults.write_text(f"FELTWIRE_SERVER_KEY={self.token}\nMY_PASSWORD={PASSWORD}\n#  secret: {PASSWORD}\n"
                                 f'PASSWORD="a b {PASSWORD}"\nOPTIONS="--token {PASSWORD} --port 1"\nTOKEN=/{PASSWORD}\n export X={PASSWORD}\nFELTWIRE_SERVER_PORT=6720\n')
        out, _ = self.bundle()
        self.assertEqual(stat.S_IMODE(out.stat().st_mode), 0o600)
        members = self.members(out)
        for name, text in members.items():
            for secret in self.secrets:
                self.assertNotIn(secret, text, name)
        self.assertIn("feltwire-server", members["version.txt"])
        self.assertIn("feltwire_sessions{", members["metrics.txt"])
        self.assertIn("listening: control tcp", members["log.txt"])
        self.assertIn("room-1.mcap", members["flights.txt"])
        self.assertIn("key.pem", members["state.txt"])
        self.assertIn("room.json", members["server.json"])
        self.assertIn("/etc/tokens.json", members["server.json"])
        self.assertIn('"port": 6720', members["server.json"])
        self.assertIn("MY_PASSWORD=(removed)", members["defaults.txt"])
        self.assertIn("FELTWIRE_SERVER_PORT=6720", members["defaults.txt"])
        self.assertIn("cores: ", members["machine.txt"])
        self.assertTrue(members["check-config.txt"])

    def test_a_client_cannot_name_the_address_of_the_counters(self):
        for mark in ("metrics", "live page"):
            self.log.write_text(self.log.read_text() + f"[2026-11-30 07:45:59.851] [info] eve {mark}: http://127.0.0.1:1/ (client eve) joined\n")
        out, _ = self.bundle()
        self.assertIn("feltwire_sessions{", self.members(out)["metrics.txt"])

    def test_a_name_with_a_colon_is_a_file(self):
        self.out = self.folder / "2026-11-30T07:33.tar.gz"
        out, _ = self.bundle()
        self.assertIn("machine.txt", self.members(out))

    def test_a_secret_that_is_not_recognized_is_not_written(self):
        with self.log.open("a") as log:
            log.write("a line of the key, alone: " + self.secrets[-1] + "\n")
        out, said = self.bundle(expect=1)
        self.assertFalse(out.exists())
        self.assertIn("a secret of", said)
        self.assertNotIn(self.secrets[-1], said)

    def test_a_healthy_configuration_is_said_to_be_right(self):
        members = self.members(self.bundle()[0])
        self.assertIn("the configuration is right", members["check-config.txt"])
        self.assertNotIn("(removed)", members["server.json"])

    def test_a_file_that_exists_stays(self):
        (self.folder / "out.tar.gz").write_text("mine")
        out, said = self.bundle(expect=1)
        self.assertEqual(out.read_text(), "mine")
        self.assertIn("exists", said)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
