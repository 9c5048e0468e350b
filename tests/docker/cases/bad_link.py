"""A line of 20 ms +- 10 ms each way, 5 % loss in bursts, reordering and duplicates: passive, calm, and straight."""

import json

from judge import Recording, expect_passive, oscillation, report

LINK = "delay=20,jitter=10,loss=5,burst=4,reorder=2,duplicate=2,seed=7"
SECONDS = 8.0
# The tasks of the hands. Each runs with the replies' force alone and with the local contact model.
TASKS = {
    "press": ["--device", "simulated:path=press,center=0.03,-0.02,-0.05,depth=0.005"],
    "ball": ["--device", "simulated:path=orbit,center=0.05,0.05,-0.01,radius=0.02,depth=0"],
}
STILL = {"press": "z"}  # the task that stands still, and the direction that it presses in


def run(compose, judge):
    compose.server()
    compose.link(LINK)
    compose.up("server")
    compose.up("link")
    hands = {}
    for task, options in TASKS.items():
        for model in (False, True):
            name = task + ("-model" if model else "")
            compose.client(name, to="link", networks=["hands"], duration=SECONDS,
                           options=options + (["--local-model", "whole"] if model else []))
            hands[name] = task
    compose.up(*hands)
    judge.expect("exit codes", compose.wait(*hands), equal=[0] * len(hands))
    scene = compose.counters()["room"]
    ended = compose.stop("link")
    judge.expect("link: exit code at SIGTERM", ended["link"][0], equal=0)

    # The line was as bad as it was meant to be.
    for client in json.loads((compose.out / "link.json").read_text())["clients"]:
        for way in ("up", "down"):
            line, who = client["link"][way], f"link {way} of {client['client']}"
            judge.expect(f"{who}: lost [%]", round(100 * line["lost"] / line["entered"], 2), at_least=3.0, at_most=8.0)
            judge.expect(f"{who}: reordered", line["reordered"], at_least=50)
            judge.expect(f"{who}: duplicated", line["duplicated"], at_least=50)
            judge.expect(f"{who}: mean delay [ms]", round(line["measured_delay_ms"]["mean"], 1), at_least=20.0)

    for name, task in hands.items():
        told = report(compose.out / f"{name}.json")
        recording = Recording(compose.out / f"{name}.csv")
        expect_passive(judge, name, told, recording)
        judge.expect(f"{name}: disconnections", told["disconnections"], equal=0)
        judge.expect(f"{name}: largest force [N]", round(told["max_force_n"], 2), at_least=0.3)
        judge.expect(f"{name}: mean direction error [deg]", told["direction_error_deg"]["mean"], at_most=1.0)
        judge.expect(f"{name}: 99 % of the direction errors [deg]", told["direction_error_deg"]["p99"], at_most=1.0)
        if task in STILL:
            judge.expect(f"{name}: oscillation [um RMS]", round(1e6 * oscillation(recording.columns[STILL[task]]), 2),
                         at_most=20.0)
    judge.expect("server: stale or repeated datagrams were dropped", scene["dropped"]["packet_number"] + scene["dropped"]["stale"],
                 at_least=50)
