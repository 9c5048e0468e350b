#!/usr/bin/env python3
"""Measures how many hands one core of a server holds: hands_a_core.py BUILD_FOLDER [--scene FILE] [--profile P] [--hands N,N,...]

For each number of hands it starts a server whose threads share core 0, real sessions from programs feltwire-load on the other cores, and
one complete client, the witness. It prints a row each: the server's share of the core, the round trips, the memory, and the error of the
force that the witness felt against the force of the same scene in its own program, at the same places.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
SETTLING = 2.0  # [s] after the last join
TICKS = os.sysconf("SC_CLK_TCK")


def pin(process, cores):
    for thread in os.listdir(f"/proc/{process}/task"):
        os.sched_setaffinity(int(thread), cores)


def cpu_time(process):
    fields = pathlib.Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def resident(process):
    """[bytes]"""
    return int(pathlib.Path(f"/proc/{process}/statm").read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Load:
    """A program feltwire-load. rows: its lines so far, each with the time at which it came."""

    def __init__(self, server, scene, hands, profile, seed, cores):
        environment = dict(os.environ, FELTWIRE_FINGERPRINT_FILE=server.fingerprint_file, FELTWIRE_TOKEN_FILE=server.token_file)
        self.process = subprocess.Popen(
            [BUILD / "bin/feltwire-load", "--connect", server.address, "--scene", scene, "--hands", str(hands), "--profile", profile,
             "--seed", str(seed), "--rate", str(OPTIONS.rate), "--seconds", "100000"], env=environment, stdout=subprocess.PIPE, text=True)
        pin(self.process.pid, cores)
        self.wanted, self.rows = hands, []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            self.rows.append((time.monotonic(), json.loads(line)))

    def complete(self):
        if self.process.poll() is not None:
            sys.exit("feltwire-load ended; its words stand above")
        return bool(self.rows) and self.rows[-1][1]["hands"] >= self.wanted

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.reader.join()


def felt_error(file, scene, begin, end):
    """The RMS of the difference between the force that the witness's program wanted and that of the scene itself, over the RMS of the
    latter; and the share of its ticks with a force. begin, end: [s] of the recording."""
    sample = feltwire.read(file)["/hand/sample"]
    ticks = [i for i, t in enumerate(sample["time"]) if begin <= t - sample["time"][0] < end]
    places = [sample["position"][i] for i in ticks]
    table = {"t": [sample["time"][i] for i in ticks], **{axis: [p[k] for p in places] for k, axis in enumerate("xyz")}}
    true = feltwire.lab.touch(scene=scene, table=table).table
    wrong = whole = 0.0
    touched = 0
    for row, i in enumerate(ticks):
        there = [float(a) + float(b) for a, b in zip(true["elastic"][row], true["frictional"][row])]
        here = [a + b for a, b in zip(sample["elastic"][i], sample["frictional"][i])]
        wrong += sum((a - b) ** 2 for a, b in zip(here, there))
        whole += sum(b ** 2 for b in there)
        touched += any(there)
    return (wrong / whole) ** 0.5 if whole else float("nan"), touched / max(len(ticks), 1)


def measure(scene, hands, profile, seconds, folder):
    loads_cores = set(range(1, os.cpu_count())) or {0}
    many = {"max_sessions_per_scene": hands + 8, "max_sessions_per_client": hands + 8, "join_rate": 1e5, "join_burst": 1e5,
            "handshake_rate": 1e5, "handshake_burst": 1e5, "silence_timeout": 10}
    with feltwire.serve(scene, **many) as server:
        process = server.process.pid
        pin(process, {0})
        empty = resident(process)
        loads = []
        try:
            for number in range(max(1, min(len(loads_cores), 8))):
                share = hands // len(loads_cores) + (number < hands % len(loads_cores))
                loads.append(Load(server, server.scenes[0], share, profile, number + 1, loads_cores))
            while not all([load.complete() for load in loads]):
                time.sleep(0.2)
            record = folder / f"witness-{hands}.mcap"
            with server.join(traffic=profile, device="simulated:path=slide", record=record, flight_recorder="off",
                             duration=SETTLING + seconds) as witness:
                pin(os.getpid(), loads_cores)
                time.sleep(SETTLING)
                begin, used = time.monotonic(), cpu_time(process)
                time.sleep(seconds - 0.5)
                wall, used, memory = time.monotonic() - begin, cpu_time(process) - used, resident(process)
                witness.wait()
            rows = [row for load in loads for at, row in load.rows if begin + 1.0 < at < begin + wall]
        finally:
            for load in loads:
                load.end()
    error, touched = felt_error(record, scene, SETTLING, SETTLING + seconds - 0.5)
    replies = sum(row["replies"] / row["seconds"] for row in rows) / len(rows) * len(loads)
    datagrams = sum(row["datagrams"] / row["seconds"] for row in rows) / len(rows) * len(loads)
    return {"hands": hands, "core": 100 * used / wall, "up": datagrams / hands, "down": replies / hands,
            "p50": statistics.median(row["p50_us"] for row in rows) / 1e3, "p99": statistics.median(row["p99_us"] for row in rows) / 1e3,
            "worst": max(row["p99_us"] for row in rows) / 1e3, "silent": max(row["silent"] for row in rows), "ended": max(row["ended"] for row in rows),
            "skipped": sum(row["skipped"] for row in rows) / sum(1000 * row["seconds"] for row in rows),
            "memory": (memory - empty) / hands / 1024, "error": 100 * error, "touched": 100 * touched}


def main():
    print(f"server on core 0, {os.cpu_count() - 1 or 1} load(s) on the others; profile {OPTIONS.profile}, scene {OPTIONS.scene}, {OPTIONS.seconds:g} s each")
    print("  hands   core  us/datagram  up/s  down/s   p50    p99  worst p99  silent  ended  load late  kB a hand  felt error  touched")
    print("             %                              ms     ms         ms                          %                       %        %")
    with tempfile.TemporaryDirectory() as folder:
        for hands in OPTIONS.hands:
            r = measure(OPTIONS.scene, hands, OPTIONS.profile, OPTIONS.seconds, pathlib.Path(folder))
            each = 1e4 * r["core"] / (r["up"] * hands)
            print(f"{hands:7} {r['core']:6.1f} {each:12.2f} {r['up']:5.1f} {r['down']:7.1f} {r['p50']:5.2f} {r['p99']:6.2f} {r['worst']:10.2f} "
                  f"{r['silent']:7} {r['ended']:6} {100 * r['skipped']:10.1f} {r['memory']:10.1f} {r['error']:11.2f} {r['touched']:8.0f}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--scene", type=pathlib.Path, default=SOURCE / "scenes/room.json")
    parser.add_argument("--profile", default="wan")
    parser.add_argument("--hands", type=lambda text: [int(word) for word in text.split(",")], default=[250, 500, 1000, 2000])
    parser.add_argument("--rate", type=float, default=1000.0, help="[Hz] of the servos of the load. The packet rate of the profile stays")
    parser.add_argument("--seconds", type=float, default=10.0)
    OPTIONS = parser.parse_args()
    BUILD = OPTIONS.build.resolve()
    os.environ.update(FELTWIRE_LIBRARY=str(BUILD / "lib/libfeltwire.so.0"), FELTWIRE_PROGRAMS=str(BUILD / "bin"))
    sys.path.insert(0, str(SOURCE / "client/python"))
    import feltwire
    import feltwire.lab
    main()
