"""The server killed and started again: the force fades to nothing within the hold time, the hands come back by
themselves, and feel again."""

import time

from judge import Recording, expect_passive, report

HOLD_TIME = 0.1  # [s] the client's default
BEFORE, AWAY, AFTER = 3.0, 3.0, 6.0  # [s]
SLEW = 40.0  # [N/s] that the hands ask for: less than a tap rises with by itself
# Both leave the surface again and again: what a hand sank into meanwhile it feels once it has been outside.
HANDS = {"table": ["--device", "simulated:path=taps,frequency=1"],
         "can": ["--device", "simulated:path=taps,frequency=1.5,center=-0.06,0.04,0.03"]}


def run(compose, judge):
    compose.server()
    compose.up("server")
    for name, options in HANDS.items():
        compose.client(name, options=[*options, "--slew", f"{SLEW:g}"])
    compose.up(*HANDS)
    time.sleep(BEFORE)
    before = compose.counters()["room"]
    compose.act("kill", "server")
    time.sleep(AWAY)
    compose.act("start", "server")
    time.sleep(AFTER)
    after = compose.counters()["room"]
    ended = compose.stop(*HANDS)

    for name in HANDS:
        judge.expect(f"{name}: exit code", ended[name][0], equal=0)
        told = report(compose.out / f"{name}.json")
        recording = Recording(compose.out / f"{name}.csv")
        expect_passive(judge, name, told, recording)
        judge.expect(f"{name}: sessions lost", told["disconnections"], equal=1)
        judge.expect(f"{name}: sessions found again", told["reconnections"], equal=1)
        force, ticks = recording.held_when_older_than(HOLD_TIME + 0.002)
        judge.expect(f"{name}: ticks without an answer", ticks, at_least=1000)
        judge.expect(f"{name}: force held beyond the hold time [N]", force, equal=0.0)
        end = recording.t[-1]
        judge.expect(f"{name}: largest force before [N]", recording.most_held(0.5, 2.5), at_least=0.5)
        judge.expect(f"{name}: largest force at last [N]", recording.most_held(end - 2.0, end), at_least=0.5)
        judge.expect(f"{name}: fastest rise of the force [N/s]", recording.fastest_rise(), at_most=1.05 * SLEW)
    for when, scene in (("before", before), ("after", after)):
        judge.expect(f"server {when}: sessions", scene["sessions"], equal=len(HANDS))
