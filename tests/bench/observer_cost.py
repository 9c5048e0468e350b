#!/usr/bin/env python3
"""Measures what an observer of 16 hands costs a program, in Python and in C, and the calls of a hand in C: observer_cost.py BUILD_FOLDER

It prints the share of a core of a Python program that reads all hands 60 times a second, and the shortest mean time of a call.
"""
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import timeit

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(sys.argv[1]).resolve()
os.environ.update(FELTWIRE_LIBRARY=str(BUILD / "lib/libfeltwire.so.0"), FELTWIRE_PROGRAMS=str(BUILD / "bin"))
sys.path.insert(0, str(SOURCE / "client/python"))
import feltwire  # noqa: E402

HANDS, RATE, SECONDS, CALLS, ROUNDS = 16, 60, 15, 1000, 200  # few calls a round: one that is not interrupted counts


def watch(address, fingerprint_file, token_file):
    with feltwire.observe(address, "plane", fingerprint_file=fingerprint_file, token_file=token_file, period=0.005) as observer:
        observer.wait()
        begin, spent, reads = time.monotonic(), time.process_time(), 0
        while time.monotonic() < begin + SECONDS:
            observer.wait()
            hands = observer.hands()
            reads += 1
            time.sleep(max(0.0, begin + reads / RATE - time.monotonic()))
        wall = time.monotonic() - begin
        print(f"Python: {len(hands)} hands, {reads / wall:.0f} reads/s, {100 * (time.process_time() - spent) / wall:.1f} % of a core")
        for call in (observer.latest, observer.hands):
            print(f"Python: {call.__name__}() {1e6 * min(timeit.repeat(call, number=CALLS, repeat=ROUNDS)) / CALLS:.2f} us")


def main():
    with feltwire.serve(SOURCE / "scenes/plane.json", max_sessions_per_client=2 * HANDS) as server, contextlib.ExitStack() as stack:
        for _ in range(HANDS):
            stack.enter_context(server.join(rate=RATE, hold_time=1, let_go_after=1, flight_recorder="off"))
        way = [server.address, server.fingerprint_file, server.token_file]
        subprocess.run([sys.executable, __file__, BUILD, *way], check=True)
        program = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory())) / "observer_cost"
        subprocess.run([os.environ.get("CC", "cc"), "-O2", "-std=c99", "-I", SOURCE / "client/c_api", SOURCE / "tests/bench/observer_cost.c",
                        BUILD / "lib/libfeltwire.so.0", f"-Wl,-rpath,{BUILD / 'lib'}", "-o", program], check=True)
        subprocess.run([program, *way, "plane"], check=True)


if __name__ == "__main__":
    watch(*sys.argv[2:]) if len(sys.argv) > 2 else main()
