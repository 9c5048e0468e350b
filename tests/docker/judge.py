"""Expectations of a test, and what the clients' recordings say."""

import csv
import json
import math

ROUNDING = 1e-12   # [J]
TICK_RATE = 1000.0  # [1/s] of every client here
STALL = 50         # ticks that the first or the last one may be late by: the time of a run does not know of it


class Judge:
    """Collects expectations, so that a failed run says all that was wrong with it."""

    def __init__(self):
        self.lines = []
        self.failures = []

    def expect(self, what, value, at_least=None, at_most=None, equal=None):
        bounds = [f"{word} {bound}" for word, bound in (("at least", at_least), ("at most", at_most), ("equal", equal))
                  if bound is not None]
        good = (value is not None and (at_least is None or value >= at_least)
                and (at_most is None or value <= at_most) and (equal is None or value == equal))
        line = f"{'ok  ' if good else 'FAIL'} {what}: {value} ({' and '.join(bounds)})"
        self.lines.append(line)
        if not good:
            self.failures.append(line)

    def measured(self, what, value):
        """A figure that is told and not judged, as it depends on the machine."""
        self.lines.append(f"told {what}: {value}")
        print(f"  {what}: {value}", flush=True)


class Recording:
    """Rows of --record (docs/devices.md), as columns."""

    def __init__(self, file):
        with open(file, newline="") as lines:
            rows = csv.reader(lines)
            header = next(rows)
            table = [[float(cell) for cell in row] for row in rows if len(row) == len(header)]
        self.columns = dict(zip(header, map(list, zip(*table)))) if table else {name: [] for name in header}
        self.t = self.columns["t"]
        self.age = self.columns["age"]
        self.held = [math.hypot(*f) for f in self.vectors("r")]  # [N]

    def vectors(self, letter):
        """r: held, e: elastic command, f: frictional command."""
        return list(zip(*(self.columns[letter + axis] for axis in "xyz")))

    def longest_step(self):
        """[m] that the hand went between two ticks."""
        places = list(zip(self.columns["x"], self.columns["y"], self.columns["z"]))
        return max((math.dist(before, after) for before, after in zip(places, places[1:])), default=0.0)

    def fastest_rise(self):
        """[N/s] of the force held, over the time between two rows."""
        return max((after - before) / max(t1 - t0, 1e-6) for before, after, t0, t1
                   in zip(self.held, self.held[1:], self.t, self.t[1:]))

    def after(self, time):
        """Index of the first row from `time` [s] on."""
        return next((i for i, t in enumerate(self.t) if t >= time), len(self.t))

    def most_held(self, begin, end):
        """[N] the largest force held in this time [s]; None without a row."""
        return max(self.held[self.after(begin):self.after(end)], default=None)

    def held_when_older_than(self, age):
        """[N] the largest force held on a command older than that [s], and how many such rows there are."""
        forces = [force for force, old in zip(self.held, self.age) if old > age]
        return max(forces, default=0.0), len(forces)


def oscillation(values, window=51):
    """RMS of what is faster than a centred moving average, over the second half (sim/measure/experiment_metrics.hpp)."""
    begin, half = max(len(values) // 2, window // 2), window // 2
    if len(values) - half <= begin:
        return None
    total, squares, count = sum(values[begin - half:begin + half + 1]), 0.0, 0
    for i in range(begin, len(values) - half):
        squares += (values[i] - total / window) ** 2
        count += 1
        if i + half + 1 < len(values):
            total += values[i + half + 1] - values[i - half]
    return math.sqrt(squares / count)


def report(file):
    return json.loads(file.read_text())


def expect_passive(judge, name, told, recording):
    """What every hand is promised, whatever the network does. A tick that the machine skipped held its force too long, which no law can
    foresee: what the hand got then is a debt of the account, and no force acts until it is paid. So a debt comes from one hold, and is no
    more than the largest force times the longest way between two ticks."""
    account = told["account"] or {"overdrawn": 0, "largest_debt_j": 0.0}
    debt = account["largest_debt_j"]
    judge.expect(f"{name}: debts of the account, {told['overruns']} skipped ticks", account["overdrawn"], at_most=told["overruns"])
    judge.expect(f"{name}: largest debt [J]", debt, at_most=told["max_force_n"] * recording.longest_step() + ROUNDING)
    judge.expect(f"{name}: least energy margin [J]", told["least_energy_margin_j"], at_least=-debt - ROUNDING)
    while_paid = told["account_cut_samples"] + told["overruns"] if account["overdrawn"] else 0
    judge.expect(f"{name}: bound violations", told["bound_violations"], at_most=while_paid)
    judge.expect(f"{name}: device faults", told["device_faults"], equal=0)
    judge.expect(f"{name}: absurd commands", told["refused_samples"], equal=0)


def expect_undisturbed(judge, name, told, recording):
    """A hand whose line was clean. How many ticks a second the machine has time for is not judged: each deadline was met, or counted as
    passed over."""
    expect_passive(judge, name, told, recording)
    deadlines = told["samples"] + told["missed_deadlines"]
    judge.expect(f"{name}: deadlines met and passed over, less those that there were", round(deadlines - TICK_RATE * told["duration_s"], 1),
                 at_least=-STALL, at_most=STALL)
    judge.expect(f"{name}: datagrams lost", told["lost"], equal=0)
    judge.expect(f"{name}: disconnections", told["disconnections"], equal=0)
    judge.expect(f"{name}: largest force [N]", told["max_force_n"], at_least=0.5)


def expect_honest(judge, scene):
    """A server's counters of a scene where nobody sent garbage."""
    name = scene["scene"]
    judge.expect(f"scene {name}: unsent replies", scene["unsent"], equal=0)
