"""A line cut for 3 s, a client killed and started again, a client paused for 5 s, all beside one that is left in peace:
that one feels nothing of it, and the others come back without a jump."""

import shutil
import time

from composition import wait_until
from judge import Recording, expect_honest, expect_passive, expect_undisturbed, report

CUT, PAUSED = 3.0, 5.0  # [s]
SLEW = 40.0  # [N/s] that the hands ask for: less than a tap rises with by itself
TAPS = ["--device", "simulated:path=taps,frequency=1", "--slew", f"{SLEW:g}"]
# A process that is frozen holds what it held last, and a hand that moves on meanwhile is given energy that nothing
# bounds (docs/docker.md). So this one is caught in the air, where it is for two seconds and more.
SLOW_TAPS = ["--device", "simulated:path=taps,frequency=0.2", "--slew", f"{SLEW:g}"]


def has_just_left(recording):
    """Whether the hand held something half a second before its last row, and nothing since a moment."""
    felt = Recording(recording)
    end = felt.t[-1] if felt.t else 0.0
    return (felt.most_held(end - 0.5, end - 0.4) or 0.0) > 0.0 and felt.most_held(end - 0.1, end) == 0.0


def run(compose, judge):
    compose.server(networks=["line", "cable"])
    compose.client("peace", options=["--device", "simulated:path=slide", "--slew", f"{SLEW:g}"])
    compose.client("cut", networks=["cable"], options=TAPS)
    compose.client("killed", options=TAPS)
    compose.client("paused", options=SLOW_TAPS)
    compose.up("server")
    compose.up("peace", "cut", "killed", "paused")
    time.sleep(3.0)

    compose.network("disconnect", "cable", "cut")
    time.sleep(CUT)
    compose.network("connect", "cable", "cut")

    compose.act("kill", "killed")
    for file in ("killed.csv", "killed.log"):
        if (compose.out / file).exists():
            shutil.copy(compose.out / file, compose.out / f"before-{file}")
    compose.act("start", "killed")

    wait_until("the paused hand to leave the table", lambda: has_just_left(compose.out / "paused.csv"), 30)
    compose.act("pause", "paused")
    time.sleep(PAUSED)
    compose.act("unpause", "paused")
    time.sleep(9.0)  # a slow tap, and a half
    scene = compose.counters()["room"]
    ended = compose.stop("peace", "cut", "killed", "paused")
    judge.expect("exit codes", [code for code, _ in ended.values()], equal=[0] * len(ended))

    peace = report(compose.out / "peace.json")
    expect_undisturbed(judge, "peace", peace, Recording(compose.out / "peace.csv"))
    for name, lost in (("cut", 1), ("killed", 0), ("paused", 1)):
        told = report(compose.out / f"{name}.json")
        expect_passive(judge, name, told, Recording(compose.out / f"{name}.csv"))
        judge.expect(f"{name}: sessions lost", told["disconnections"], equal=lost)
        judge.expect(f"{name}: sessions found again", told["reconnections"], equal=lost)
    for name in ("peace", "cut", "killed", "before-killed", "paused"):
        recording = Recording(compose.out / f"{name}.csv")
        end = recording.t[-1]
        judge.expect(f"{name}: largest force in its last six seconds [N]", recording.most_held(end - 6.0, end), at_least=0.5)
        judge.expect(f"{name}: fastest rise of the force [N/s]", recording.fastest_rise(), at_most=1.05 * SLEW)
    expect_honest(judge, scene)
    judge.expect("server: sessions at last", scene["sessions"], equal=4)
    judge.expect("server: sessions that fell silent", scene["silent"], equal=3)
