"""Runs feltwire-server as its systemd unit would, and a hand in its scene: run_unit.py

As root, in a system that has the packages. The unit's sandbox is left out: it needs systemd.
"""
import json
import os
import pathlib
import pwd
import re
import shlex
import subprocess
import tempfile
import time

LONGEST = 60.0  # [s]


def settings(path):
    """The settings of a unit or of a file with variables, each with its last value."""
    lines = pathlib.Path(path).read_text(encoding="utf-8").splitlines()
    return dict(line.split("=", 1) for line in lines if "=" in line and not line.startswith("#"))


def start(unit, out):
    """The server of the unit: its user, its folder, its variables, its command."""
    user = pwd.getpwnam(unit["User"])
    state = pathlib.Path("/var/lib", unit["StateDirectory"])
    state.mkdir(mode=int(unit["StateDirectoryMode"], 8), exist_ok=True)
    os.chown(state, user.pw_uid, user.pw_gid)
    return subprocess.Popen(shlex.split(unit["ExecStart"]), env=settings(unit["EnvironmentFile"].lstrip("-")), cwd="/", stdout=out,
                            stderr=subprocess.STDOUT, user=user.pw_uid, group=user.pw_gid, extra_groups=[], umask=int(unit["UMask"], 8))


def port_of(server, out):
    end = time.monotonic() + LONGEST
    while time.monotonic() < end and server.poll() is None:
        if found := re.search(r"listening: control tcp (\d+)", out.read_text()):
            return found[1]
        time.sleep(0.02)
    raise SystemExit(f"the server does not listen:\n{out.read_text()}")


def main():
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        out, report = pathlib.Path(name, "server.out"), pathlib.Path(name, "report.json")
        with open(out, "w", encoding="utf-8") as stream:
            server = start(settings("/lib/systemd/system/feltwire-server.service"), stream)
        try:
            port = port_of(server, out)
            subprocess.run(["feltwire-client", "--connect", f"127.0.0.1:{port}", "--scene", "room", "--fingerprint-file",
                            "/var/lib/feltwire/fingerprint", "--token-file", "/var/lib/feltwire/local.token", "--duration", "3",
                            "--flight-recorder", "off", "--report", report], check=True, stderr=subprocess.DEVNULL, timeout=LONGEST)
        finally:
            server.terminate()
            status = server.wait(LONGEST)
        force = json.loads(report.read_text(encoding="utf-8"))["max_force_n"]
        print(f"the service started as user feltwire, and a hand felt {force:.2f} N after {time.monotonic() - begin:.1f} s")
        if force <= 0.3 or status != 0:
            raise SystemExit(f"largest force {force} N, exit status of the server {status}:\n{out.read_text()}")


main()
