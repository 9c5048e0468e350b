"""An uninvited client, and a flood of garbage from a container: no hand loses a datagram, its session or its force, and every
datagram of the flood is counted. How the flood changes the round trips is a measurement: feltwire-netbench --only flood."""

import shutil

import composition
from judge import Recording, expect_honest, expect_undisturbed, report

# Each hand runs with the flood and without it, in turns. In quiet rounds as much garbage goes to another server.
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
            compose.client(name, duration=SECONDS, options=["--device", f"simulated:path=slide,radius=0.02,seed={seed}"])
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

    for names in rounds.values():
        for name in names:
            expect_undisturbed(judge, name, report(compose.out / f"{name}.json"), Recording(compose.out / f"{name}.csv"))

    expect_honest(judge, after)
    judge.expect("sessions that there were", after["sessions_served"], equal=len(rounds) * len(HANDS))
    dropped = {reason: after["dropped"][reason] - before["dropped"][reason] for reason in after["dropped"]}
    judge.expect("garbage dropped", sum(dropped.values()), at_least=0.5 * RATE * SECONDS * ROUNDS)
    for reason in ("size", "magic", "version", "kind", "reserved", "session"):
        judge.expect(f"garbage dropped for its {reason}", dropped[reason], at_least=100)
    judge.expect("garbage that came further", sum(dropped[reason] for reason in ("malformed", "count", "order", "not_finite")), equal=0)
    judge.expect("samples missed", after["missed"], equal=0)
