#!/usr/bin/env python3
"""Has every allocation and every system call of a session fail in turn, and judges what becomes of it.

A point is a place in the program (the last 14 calls that lead to an allocation or a system call) and the first, or where
there were more the middle one, of the calls that are made from there in a session of two seconds. Each point is a session
of its own, with that one call failing, in feltwire-client or in feltwire-server. It must end well:

- the program ends by itself, with exit code 0, 1 or 2, never by a signal; what is not served says why;
- the simulated device was told zero last, and no force was held longer than the hold time without a word;
- a client whose hand was given a force leaves a report.

Usage: run.py --client FILE --server FILE --library FILE [--sample N] [--jobs N] [--only client|server]
"""

import argparse
import collections
import concurrent.futures
import json
import mmap
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOLD_TIME = 0.1  # [s]
LONGEST = 60.0  # [s] then a program hangs
HEADER = struct.Struct("<QqQddqqQ")
PLACE = struct.Struct("<QQQ")
PLACES = 1 << 15
LOG_SIZE = HEADER.size + PLACES * PLACE.size
CALLS = ["malloc", "calloc", "realloc", "aligned_alloc", "socket", "connect", "bind", "listen", "accept", "send", "recv",
         "poll", "epoll_create", "epoll_ctl", "epoll_wait", "eventfd", "signalfd", "timerfd_create", "timerfd_settime",
         "read", "write", "fsync", "rename", "getrandom", "setsockopt", "getsockopt", "getsockname", "getpeername", "flock",
         "fchmod", "mlockall", "mmap", "open", "fopen", "pthread_create"]
NO_FAULTS = "1"  # as a place: nothing is counted, nothing fails

Point = collections.namedtuple("Point", "target call place nth")
Log = collections.namedtuple("Log", "injected injected_at told force largest told_at longest_hold overflow")


class LogFile:
    def __init__(self, path):
        self.path = path
        with open(path, "wb") as file:
            file.truncate(LOG_SIZE)

    def head(self):
        with open(self.path, "rb") as file:
            return Log(*HEADER.unpack(file.read(HEADER.size)))

    def places(self):
        with open(self.path, "rb") as file:
            data = file.read()
        for i in range(PLACES):
            place, count, call = PLACE.unpack_from(data, HEADER.size + i * PLACE.size)
            if place != 0:
                yield place, count, CALLS[call]


class Bench:
    """One of the jobs: ports, a folder and a server of its own."""

    def __init__(self, options, number, folder):
        self.options = options
        self.folder = folder / str(number)
        self.folder.mkdir()
        self.server = None
        self.port = 0
        self.starts = 0

    def environment(self, log, place=None, nth=1):
        environment = dict(os.environ, LD_PRELOAD=str(self.options.library), FELTWIRE_FAULT_LOG=str(log.path),
                           XDG_STATE_HOME=str(self.folder))
        if place is not None:
            environment["FELTWIRE_FAULT_PLACE"] = place
        environment["FELTWIRE_FAULT_NTH"] = str(nth)
        environment["FELTWIRE_FAULT_TRACE"] = str(log.path) + ".trace"
        return environment

    def start_server(self, scenes, port=0, environment=None):
        """Its process once it says that it listens, or has ended."""
        self.starts += 1
        out = open(self.folder / f"server-{self.starts}.out", "w+")
        command = [self.options.server, "--port", str(port), "--state", self.options.state, "--join-rate", "1000",
                   "--join-burst", "1000", "--summary", self.folder / "summary.json"]
        for scene in scenes:
            command += ["--scene", ROOT / "scenes" / scene]
        process = subprocess.Popen([str(word) for word in command], stdout=out, stderr=subprocess.STDOUT,
                                   env=environment or dict(os.environ, XDG_STATE_HOME=str(self.folder)))
        process.out = out
        until = time.monotonic() + LONGEST
        while time.monotonic() < until:
            text = self.text(process)
            if "\njoin: " in text:
                self.port = int(text.split("listening: control tcp ")[1].split(",")[0])
                break
            if process.poll() is not None:
                break
            time.sleep(0.02)
        return process

    @staticmethod
    def text(process):
        return Path(process.out.name).read_text(errors="replace")

    def start_client(self, scene, duration, log, place, nth):
        for name in ("report.json", "felt.csv"):
            (self.folder / name).unlink(missing_ok=True)
        out = open(self.folder / "client.out", "w+")
        process = subprocess.Popen(
            [str(word) for word in (
                self.options.client, "--connect", f"127.0.0.1:{self.port}", "--scene", scene, "--fingerprint-file",
                self.options.state / "fingerprint", "--token-file", self.options.state / "local.token", "--duration",
                duration, "--hold-time", HOLD_TIME, "--reconnect", 3, "--report", self.folder / "report.json", "--record",
                self.folder / "felt.csv")],
            stdout=out, stderr=subprocess.STDOUT, env=self.environment(log, place, nth))
        process.out = out
        return process

    def end(self, process):
        """Exit code; None: it hangs."""
        try:
            return process.wait(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return None
        finally:
            process.out.close()

    def close(self):
        if self.server is not None and self.server.poll() is None:
            self.server.send_signal(signal.SIGTERM)
            self.end(self.server)

    # Sessions

    def client_session(self, place=None, nth=1):
        """A client that loses its server on the way and finds another; the client is the target."""
        log = LogFile(self.folder / "log")
        if self.server is None or self.server.poll() is not None:
            self.server = self.start_server(["plane.json"], self.port)
        client = self.start_client("plane", 2, log, place, nth)
        begun = time.monotonic()
        # Half way, by what its hand was told; at once where it ends sooner.
        while client.poll() is None and log.head().told < 900 and time.monotonic() - begun < 5.0:
            time.sleep(0.05)
        if client.poll() is None:
            self.server.send_signal(signal.SIGTERM)
            self.end(self.server)
            self.server = self.start_server(["plane.json"], self.port)
        code = self.end(client)
        text = (self.folder / "client.out").read_text(errors="replace")
        return log, code, text, self.wrong_client(log.head(), code, text)

    def wrong_client(self, head, code, text):
        if code is None:
            return "the client hangs"
        if code not in (0, 1, 2):
            return f"the client ends with {code}"
        if code != 0 and "feltwire-client" not in text:
            return "the client says nothing of what failed"
        if head.force != 0.0:
            return f"the client leaves {head.force} N on the hand"
        if head.longest_hold > 1e9 * HOLD_TIME:
            return f"TIMING the client holds a force for {1e-9 * head.longest_hold:.3f} s without a word"
        if head.largest > 0.0:
            try:
                report = json.loads((self.folder / "report.json").read_text())
            except (OSError, ValueError) as error:
                return f"the client leaves no report: {error}"
            if code == 0 and report["end"] != "duration":
                return f"the client says that all is well, its report {report['end']}"
        return None

    def server_session(self, place=None, nth=1):
        """A server that a client joins, that reloads, counts and is told to end; the server is the target."""
        log, client_log = LogFile(self.folder / "log"), LogFile(self.folder / "client-log")
        server = self.start_server(self.options.scenes, 0, self.environment(log, place, nth))
        wrong, client = None, None
        if server.poll() is None:
            client = self.start_client("plane", 1.2, client_log, NO_FAULTS, 1)
            for number in (signal.SIGHUP, signal.SIGUSR1):
                time.sleep(0.4)
                if server.poll() is None:
                    server.send_signal(number)
            client_code = self.end(client)
            text = (self.folder / "client.out").read_text(errors="replace")
            wrong = self.wrong_client(client_log.head(), client_code, text)
            server.send_signal(signal.SIGTERM)
        code = self.end(server)
        text = self.text(server)
        if code is None:
            wrong = "the server hangs"
        elif code not in (0, 1, 2):
            wrong = f"the server ends with {code}"
        elif code != 0 and "feltwire-server" not in text and "[error]" not in text:
            wrong = "the server says nothing of what failed"
        return log, code, text, wrong

    def session(self, target, place=None, nth=1):
        return self.client_session(place, nth) if target == "client" else self.server_session(place, nth)


def points_of(bench, target):
    """From a session in which nothing fails."""
    log, code, text, wrong = bench.session(target)
    if wrong or code != 0:
        sys.exit(f"fault: a {target} with no fault: {wrong or code}\n{text}")
    if log.head().overflow:
        sys.exit("fault: the log is too small for all places")
    if target == "client" and not log.head().largest > 0.0:
        sys.exit("fault: the hand was given no force in a session with no fault")
    points = []
    for place, count, call in log.places():
        points.append(Point(target, call, place, 1))
        if count > 1:
            points.append(Point(target, call, place, (count + 1) // 2 if count > 2 else 2))
    if not points:
        sys.exit(f"fault: nothing was counted; is {bench.options.library} preloaded?")
    return points


def listed_points(file, bench, target):
    if file is not None and file.exists():
        return [Point(*entry) for entry in json.loads(file.read_text())]
    points = points_of(bench, target)
    if file is not None:
        file.write_text(json.dumps(points))
    return points


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("client", "server", "library"):
        parser.add_argument(f"--{name}", required=True, type=Path)
    parser.add_argument("--sample", type=int, default=0, help="so many points of each program, chosen at random; 0: all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--points", type=Path, help="of one program (--only): read from this file, or written there where it is not, so that"
                        " a long list can be played in several runs")
    parser.add_argument("--first", type=int, default=0, help="of the points in their random order, the first that is played")
    parser.add_argument("--jobs", type=int, default=2 * (os.cpu_count() or 1))
    parser.add_argument("--place", help="this one only, as a failure names it; with --nth")
    parser.add_argument("--nth", type=int, default=1)
    parser.add_argument("--only", choices=("client", "server"))
    parser.add_argument("--scenes", nargs="+", default=["plane.json", "room.json", "workshop.json"])
    parser.add_argument("--seconds", type=float, default=0.0, help="no new point after that; 0: no limit")
    options = parser.parse_args()
    options.library = options.library.resolve()
    begun = time.monotonic()
    folder = Path(tempfile.mkdtemp(prefix="feltwire-fault-"))
    options.state = folder / "state"
    benches = [Bench(options, i, folder) for i in range(options.jobs)]
    free, guard = list(benches), threading.Lock()
    # The state folder is made once, outside of what is injected.
    first = benches[0].start_server(["plane.json"])
    first.send_signal(signal.SIGTERM)
    benches[0].end(first)

    def play(point):
        if options.seconds and time.monotonic() - begun > options.seconds:
            return point, None, None, None
        with guard:
            bench = free.pop()
        try:
            for _ in range(3):  # a busy machine may be late once; what is late each time is late
                log, code, text, wrong = bench.session(point.target, f"{point.place:x}", point.nth)
                if wrong is None or not wrong.startswith("TIMING"):
                    break
            if wrong:
                trace = Path(str(log.path) + ".trace").read_text() if log.head().injected else ""
                text = text[-600:].strip() + "\n  " + trace.replace("\n", "\n  ")
            return point, log.head().injected, (code, text), wrong
        finally:
            with guard:
                free.append(bench)

    failed = 0
    for target in (options.only,) if options.only else ("client", "server"):
        points = ([Point(target, "malloc", int(options.place, 16), options.nth)] if options.place
                  else listed_points(options.points, benches[0], target))
        total = len(points)
        random.Random(options.seed).shuffle(points)
        points = points[options.first:options.first + options.sample if options.sample else None]
        injected, missed, left = 0, 0, 0
        ends = collections.Counter()
        kinds = collections.Counter()
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for number, (point, reached, end, wrong) in enumerate(pool.map(play, points), 1):
                if number % 100 == 0:
                    print(f"{target}: {number} of {len(points)}, {failed} failed, {time.monotonic() - begun:.0f} s", flush=True)
                if end is None:
                    left += 1
                    continue
                injected += reached
                missed += reached == 0
                ends[end[0]] += 1
                kinds["memory" if CALLS.index(point.call) < 4 else "system calls"] += reached
                if wrong:
                    failed += 1
                    print(f"FAILED {target}: {point.call} at {point.place:x}, call {point.nth}: {wrong}\n"
                          f"  {end[1]}", flush=True)
        print(f"{target}: {total} points, {len(points) - left} played, {injected} injected "
              f"({kinds['memory']} of memory, {kinds['system calls']} of system calls), {missed} not reached again; "
              f"exit codes {dict(ends)}", flush=True)
    for bench in benches:
        bench.close()
    print(f"{failed} failed, {time.monotonic() - begun:.0f} s; {folder}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
