#!/usr/bin/env python3
"""One session of a client over UDP on loopback, with a server of its own: a simulated hand presses on a table.

The client may be built for another processor: --emulator is what runs it then. The check fails unless the hand felt the table, the
energy bound was kept, and no datagram was lost or dropped at either end. How many ticks a second an emulator has time for is not
judged. The last line says what the client took of this machine, and its emulator with it.

usage: run_session.py CLIENT SERVER FOLDER [--emulator "qemu-aarch64 -L ROOT"] [--seconds S]

FOLDER gets the report, the recording, the counters of the server, and the output of both. It is emptied first.
"""

import argparse
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/docker"))

from judge import Judge, Recording, expect_honest, expect_passive, report  # noqa: E402

LONGEST_START = 30.0  # [s] until a server listens
LONGEST_END = 30.0    # [s] that a client may take beyond its session, and a server to end
LEAST_FORCE = 1.0     # [N] of the 2 N with which the hand presses


def begin_server(program, folder):
    """The server, and its control port."""
    out = folder / "server.log"
    with open(out, "w") as stream:
        server = subprocess.Popen(
            [program, "--port", "0", "--state", folder / "state", "--scene", SOURCE / "scenes/plane.json",
             "--summary", folder / "server.json"],
            stdout=stream, stderr=subprocess.STDOUT)
    until = time.monotonic() + LONGEST_START
    while time.monotonic() < until and server.poll() is None:
        # The line after: by then the token is written, too.
        listening = re.search(r"control tcp (\d+).*\njoin: ", out.read_text(), re.S)
        if listening:
            return server, int(listening[1])
        time.sleep(0.02)
    server.kill()
    sys.exit(f"the server does not listen:\n{out.read_text()}")


def run_client(command, folder, seconds):
    """Exit code, what the system says of the running client's memory [kB] by name, and its CPU time [s]."""
    with open(folder / "client.log", "w") as stream:
        client = subprocess.Popen(command, stdout=stream, stderr=subprocess.STDOUT)
    memory, until = {}, time.monotonic() + seconds + LONGEST_END
    while True:
        pid, status, used = os.wait4(client.pid, os.WNOHANG)
        if pid:
            return os.waitstatus_to_exitcode(status), memory, used.ru_utime + used.ru_stime
        if time.monotonic() > until:
            client.kill()
            until = float("inf")
        lines = pathlib.Path(f"/proc/{client.pid}/status").read_text().splitlines()
        memory.update((line.split(":")[0], int(line.split()[1])) for line in lines if line.startswith(("VmHWM", "VmLck")))
        time.sleep(0.1)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("client")
    arguments.add_argument("server")
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--emulator", default="")
    arguments.add_argument("--seconds", type=float, default=5.0)
    args = arguments.parse_args()

    folder = args.folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    server, port = begin_server(args.server, folder)
    try:
        code, memory, cpu = run_client(
            [*shlex.split(args.emulator), args.client, "--connect", f"127.0.0.1:{port}", "--fingerprint-file", folder / "state/fingerprint",
             "--token-file", folder / "state/local.token", "--scene", "plane", "--device", "simulated:path=press",
             "--duration", f"{args.seconds:g}", "--report", folder / "client.json", "--record", folder / "client.csv"],
            folder, args.seconds)
    finally:
        server.terminate()
        server.wait(LONGEST_END)
    if code != 0:
        sys.exit(f"the client ended with {code}:\n{(folder / 'client.log').read_text()}")

    judge, told = Judge(), report(folder / "client.json")
    expect_passive(judge, "client", told, Recording(folder / "client.csv"))
    judge.expect("client: largest force [N]", told["max_force_n"], at_least=LEAST_FORCE)
    judge.expect("client: disconnections", told["disconnections"], equal=0)
    judge.expect("client: datagrams lost", told["lost"], equal=0)
    judge.expect("client: datagrams dropped", sum(told["dropped"].values()), equal=0)
    scene, = json.loads((folder / "server.json").read_text())["scenes"]
    expect_honest(judge, scene)
    judge.expect("server: datagrams dropped", sum(scene["dropped"].values()), equal=0)
    judge.expect("server: samples missed", scene["missed"], equal=0)
    print("\n".join(judge.lines))
    whose = "client and emulator" if args.emulator else "client"
    print(f"{whose}: {told['samples'] / told['duration_s']:.0f} ticks a second, round trip p50 {told['round_trip_us']['p50']:.0f} us, "
          f"{100 * cpu / told['duration_s']:.1f} % of a core, "
          + ", ".join(f"{name} {size} kB" for name, size in sorted(memory.items())))
    return 1 if judge.failures else 0


if __name__ == "__main__":
    sys.exit(main())
