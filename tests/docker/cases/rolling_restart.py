"""A new scene file while hands are in the old one: a second server takes the name over, then the first is told to end.
The hands go on in the new scene, and nothing jumps."""

import json
import time

from judge import Recording, expect_passive, report

OLD, NEW = 600.0, 1200.0  # [N/m] stiffness of the table
SLEW = 40.0  # [N/s] that the hands ask for: less than a tap rises with by itself
BEFORE, AFTER = 3.0, 5.0  # [s]
HANDS = {"press": "0.02,0,0", "taps": "0,0.02,0"}


def scene(stiffness):
    return json.dumps({
        "name": "table", "materials": [{"name": "top", "stiffness": stiffness, "static_friction": 0.3, "dynamic_friction": 0.2}],
        "objects": [{"name": "top", "plane": {}, "material": "top"}]}, indent=1)


def felt_stiffness(recording, begin, end):
    """[N/m] least squares of the elastic command over the depth, by the recording; None without contact."""
    rows = range(recording.after(begin), recording.after(end))
    depth = [(-recording.columns["z"][i], recording.columns["ez"][i]) for i in rows]
    pressed = [(d, f) for d, f in depth if d > 1e-4 and f > 0.0]
    squares = sum(d * d for d, _ in pressed)
    return sum(d * f for d, f in pressed) / squares if squares > 0.0 else None


def run(compose, judge):
    (compose.out / "old.json").write_text(scene(OLD))
    (compose.out / "new.json").write_text(scene(NEW))
    compose.server("server-old", scenes=["/out/old.json"], alias="feltwire")
    compose.server("server-new", scenes=["/out/new.json"], alias="feltwire")
    compose.up("server-old")
    for path, center in HANDS.items():
        compose.client(path, scene="table", to="feltwire", options=["--device", f"simulated:path={path},center={center}", "--slew", f"{SLEW:g}", "--wait-for-small-force", "inf"])
    compose.up(*HANDS)
    time.sleep(BEFORE)
    compose.up("server-new")
    old = compose.counters("server-old")["table"]
    stopped = compose.stop("server-old")
    time.sleep(AFTER)
    new = compose.counters("server-new")["table"]
    ended = compose.stop(*HANDS)

    judge.expect("old server: exit code at SIGTERM", stopped["server-old"][0], equal=0)
    judge.expect("old server: sessions", old["sessions"], equal=len(HANDS))
    judge.expect("new server: sessions", new["sessions"], equal=len(HANDS))
    for name in HANDS:
        judge.expect(f"{name}: exit code", ended[name][0], equal=0)
        told = report(compose.out / f"{name}.json")
        recording = Recording(compose.out / f"{name}.csv")
        expect_passive(judge, name, told, recording)
        judge.expect(f"{name}: sessions lost", told["disconnections"], equal=1)
        judge.expect(f"{name}: sessions found again", told["reconnections"], equal=1)
        end = recording.t[-1]
        judge.expect(f"{name}: stiffness before [N/m]", felt_stiffness(recording, 1.0, 2.5), at_least=0.9 * OLD, at_most=1.1 * OLD)
        judge.expect(f"{name}: stiffness after [N/m]", felt_stiffness(recording, end - 2.0, end - 0.3), at_least=0.9 * NEW, at_most=1.1 * NEW)
        judge.expect(f"{name}: fastest rise of the force [N/s]", recording.fastest_rise(), at_most=1.05 * SLEW)
