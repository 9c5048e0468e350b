"""An uninvited client, and a flood of garbage from a container: the round trip of the others stays what it was."""

import shutil
import statistics

import composition
from judge import Recording, expect_honest, expect_undisturbed, report

# The same hands with the flood and without, in turns: what else the machine is about meets both alike. The flood's own
# work, an attacker's on another machine, is among that: in quiet rounds as much is sent to somebody else.
ROUNDS, SECONDS = 5, 3.0
RATE = 20000  # [1/s] datagrams of garbage, at most
HANDS = ["one", "two", "three"]


def run(compose, judge):
    compose.server()
    compose.server("elsewhere")
    # It has an address to talk to, and no business in any scene that there is.
    compose.client("uninvited", scene="vault", duration=1, options=["--reconnect", "1"])
    shutil.copy(composition.ROOT / "tests/docker/flood.pl", compose.out)
    senders = {"flooded": "flood", "quiet": "beside"}
    for name, to in (("flood", "server"), ("beside", "elsewhere")):
        compose.service(name, ["perl", "/out/flood.pl", to, "6720", "6721", "6721", str(RATE)], ["line"])
    rounds = {(when, i): [f"{when}-{i}-{hand}" for hand in HANDS] for i in range(ROUNDS) for when in ("quiet", "flooded")}
    for names in rounds.values():
        for seed, name in enumerate(names, 1):
            compose.client(name, duration=SECONDS, options=["--path", "slide", "--radius", "0.02", "--seed", str(seed)])
    compose.up("server", "elsewhere")
    for sender in senders.values():
        compose.up(sender)
        compose.act("pause", sender)
    before = compose.counters()["room"]
    for (when, i), names in rounds.items():
        compose.act("unpause", senders[when])
        compose.up(*names)
        judge.expect(f"exit codes, {when} {i}", compose.wait(*names), equal=[0] * len(names))
        if when == "flooded" and i == 0:
            compose.up("uninvited")
            judge.expect("exit code of the uninvited", compose.wait("uninvited"), equal=[1])
        compose.act("pause", senders[when])
    for sender in senders.values():
        compose.act("unpause", sender)
    compose.stop("beside")
    judge.expect("flood: exit code", compose.stop("flood")["flood"][0], equal=0)
    after = compose.counters()["room"]

    p99 = {"quiet": [], "flooded": []}  # [us] of the middle hand, round by round
    for (when, _), names in rounds.items():
        reports = {name: report(compose.out / f"{name}.json") for name in names}
        p99[when].append(statistics.median(told["round_trip_us"]["p99"] for told in reports.values()))
        for name, told in reports.items():
            expect_undisturbed(judge, name, told, Recording(compose.out / f"{name}.csv"))
    # Each round with the quiet one before it, and the middle of these: what else a machine is about comes and goes, and is
    # several times what is looked for; the flood is in every round of its own.
    ratios = [flooded / quiet for quiet, flooded in zip(p99["quiet"], p99["flooded"])]
    judge.expect(f"p99 of the round trips, flooded to quiet, {statistics.median(p99['quiet']):.0f} us", round(statistics.median(ratios), 2), at_most=1.5)

    expect_honest(judge, after)
    judge.expect("sessions that there were", after["sessions_served"], equal=len(rounds) * len(HANDS))
    dropped = {reason: after["dropped"][reason] - before["dropped"][reason] for reason in after["dropped"]}
    judge.expect("garbage dropped", sum(dropped.values()), at_least=0.5 * RATE * SECONDS * ROUNDS)
    for reason in ("size", "magic", "version", "kind", "reserved", "session"):
        judge.expect(f"garbage dropped for its {reason}", dropped[reason], at_least=100)
    judge.expect("garbage that came further", sum(dropped[reason] for reason in ("malformed", "count", "order", "not_finite")), equal=0)
    judge.expect("samples missed", after["missed"], equal=0)
