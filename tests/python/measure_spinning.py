#!/usr/bin/env python3
"""Counts late ticks of a hand with and without a Python thread that spins beside it: measure_spinning.py [ROUNDS [SECONDS]]

A round has a run of each kind, one after the other, so that other work of the machine meets both. A tick is late if it comes a whole period of
the servo after its deadline or later, as in the report of feltwire-client.
"""
import sys
import threading
import time

from support import PATIENT, SOURCE
import feltwire


def late_ticks(server, seconds, spins):
    """(late ticks, ticks, longest time between two [s]) of a run."""
    stop = threading.Event()
    turns = 0

    def spin():
        nonlocal turns
        while not stop.is_set():
            for _ in range(1000):
                turns += 1

    thread = threading.Thread(target=spin) if spins else None
    with server.join(device="simulated:path=press", duration=seconds, **PATIENT) as hand:
        period = hand.session.servo_period
        if thread:
            thread.start()
        try:
            hand.wait()
        finally:
            stop.set()
            if thread:
                thread.join()
        times = [float(tick["time"] if hasattr(tick, "dtype") else tick.time) for tick in hand.ticks()]
    if spins and turns == 0:
        sys.exit("the thread did not spin")
    gaps = [after - before for before, after in zip(times, times[1:])]
    return sum(gap >= 2 * period for gap in gaps), len(times), max(gaps)


def main(rounds, seconds):
    with feltwire.serve(SOURCE / "scenes/plane.json") as server:
        found = {False: [], True: []}
        for _ in range(rounds):
            for spins in found:
                found[spins].append(late_ticks(server, seconds, spins))
                time.sleep(0.1)
    for spins, runs in found.items():
        late, ticks = (sum(run[i] for run in runs) for i in (0, 1))
        print(f"{'with' if spins else 'without'} a spinning thread: {late} late of {ticks} ticks in {rounds} runs, each {[run[0] for run in runs]}; "
              f"longest {1e3 * max(run[2] for run in runs):.1f} ms")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10, float(sys.argv[2]) if len(sys.argv) > 2 else 5.0)
