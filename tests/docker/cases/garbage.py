"""An uninvited client, and a flood of garbage from a container: the round trip of the others stays what it was."""

import shutil
import time

import composition
from judge import expect_honest, expect_undisturbed, report

SECONDS = 8.0
RATE = 20000  # [1/s] datagrams of garbage
HANDS = ["one", "two", "three"]


def hands(compose, when):
    """The same hands, once more; their reports."""
    names = [f"{when}-{name}" for name in HANDS]
    for seed, name in enumerate(names, 1):
        compose.client(name, duration=SECONDS, options=["--path", "slide", "--radius", "0.02", "--seed", str(seed)])
    return names


def run(compose, judge):
    compose.server()
    quiet, flooded = hands(compose, "quiet"), hands(compose, "flooded")
    # It has an address to talk to, and no business in any scene that there is.
    compose.client("uninvited", scene="vault", duration=1, options=["--reconnect", "1"])
    shutil.copy(composition.ROOT / "tests/docker/flood.pl", compose.out)
    compose.service("flood", ["perl", "/out/flood.pl", "server", "7400", "7401", "7401", str(RATE)], ["line"])
    compose.up("server")

    compose.up(*quiet)
    judge.expect("exit codes, quiet", compose.wait(*quiet), equal=[0] * len(quiet))
    before = compose.counters()["room"]
    compose.up("flood")
    compose.up(*flooded, "uninvited")
    judge.expect("exit codes, flooded", compose.wait(*flooded), equal=[0] * len(flooded))
    judge.expect("exit code of the uninvited", compose.wait("uninvited"), equal=[1])
    judge.expect("flood: exit code", compose.stop("flood")["flood"][0], equal=0)
    after = compose.counters()["room"]

    reports = {name: report(compose.out / f"{name}.json") for name in quiet + flooded}
    for name, told in reports.items():
        expect_undisturbed(judge, name, told)
    # By the middle one of the hands: one of them may meet the machine's own business.
    def p99(names):
        return sorted(reports[name]["round_trip_us"]["p99"] for name in names)[len(names) // 2]
    judge.expect("round trip p99, flooded over quiet [us]", round(p99(flooded)), at_most=round(1.5 * p99(quiet)))

    expect_honest(judge, after)
    judge.expect("sessions that there were", after["sessions_served"], equal=len(quiet) + len(flooded))
    dropped = {reason: after["dropped"][reason] - before["dropped"][reason] for reason in after["dropped"]}
    judge.expect("garbage dropped", sum(dropped.values()), at_least=0.9 * RATE * SECONDS)
    for reason in ("size", "magic", "version", "kind", "reserved", "session"):
        judge.expect(f"garbage dropped for its {reason}", dropped[reason], at_least=100)
    judge.expect("garbage that came further", sum(dropped[reason] for reason in ("malformed", "count", "order", "not_finite")), equal=0)
    judge.expect("samples missed", after["missed"], equal=0)
