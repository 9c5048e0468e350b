#!/usr/bin/env python3
"""Prints the time of a call of hand.latest() [us]: the median and the least of 20 rounds of 10,000 calls."""
import statistics
import timeit

from support import PATIENT, SOURCE, eventually
import feltwire

with feltwire.serve(SOURCE / "scenes/plane.json") as server, server.join(device="simulated:path=press", **PATIENT) as hand:
    eventually("a tick", hand.latest)
    times = [1e6 * one / 10000 for one in timeit.repeat(hand.latest, number=10000, repeat=20)]
print(f"hand.latest(): median {statistics.median(times):.2f} us, least {min(times):.2f} us")
