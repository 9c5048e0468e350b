"""A hand leads a robot: server, hand and robot in three containers, hand and robot on networks of their own. Then the robot's cable is out."""

import time

from composition import CONTROL_PORT, STATE, wait_until
from judge import Recording, expect_passive, report

SCENE = "teleoperation/seat"
TRUST = {client: ["--fingerprint-file", f"{STATE}/fingerprint", "--token-file", f"/out/{client}.token"] for client in ("hand", "robot")}
FOLLOWER = ["feltwire-follower", "--connect", f"server:{CONTROL_PORT}", *TRUST["robot"], "--scene", "seat",
            "--surroundings", "scenes/teleoperation/surroundings.json", "--at", "0,0,0.003", "--report", "/out/robot.json"]
TAPS = ["--device", "simulated:path=taps,frequency=0.5,center=0,0,0.3,depth=0.015", "--lead", "0.3"]
SECONDS = 6.0
OUT_FROM, OUT_FOR = 3.0, 4.0  # [s] of the second hand's run
SECONDS_CUT = OUT_FROM + OUT_FOR + 5.0


def seat(compose, judge):
    """Both tokens, each from a container of its own, and the robot on its seat."""
    for client, role in (("hand", "operator"), ("robot", "follower")):
        compose.service(f"{client}-token", ["feltwire-server", "token", "add", "--client", client, "--scene", "seat", "--role", role,
                                            "--expires", "1d", "--state", STATE, "--out", f"/out/{client}.token"], ["robots"])
        compose.up(f"{client}-token")
        judge.expect(f"{client}-token: exit code", compose.wait(f"{client}-token"), equal=[0])
    compose.server(scenes=[SCENE], networks=["hands", "robots"])
    compose.service("robot", FOLLOWER, ["robots"])
    compose.up("server")
    compose.up("robot")
    wait_until("the robot on its seat", lambda: "has the robot's seat" in compose.logs("robot"), 20)


def lead(compose, name, seconds):
    return compose.client(name, scene="seat", networks=["hands"], duration=seconds, options=TAPS, trust=TRUST["hand"])


def run(compose, judge):
    seat(compose, judge)
    lead(compose, "first", SECONDS)
    compose.up("first")
    judge.expect("first: exit code", compose.wait("first"), equal=[0])
    told = report(compose.out / "first.json")
    recording = Recording(compose.out / "first.csv")
    expect_passive(judge, "first", told, recording)
    judge.expect("first: datagrams lost", told["lost"], equal=0)
    judge.expect("first: largest force on the hand [N]", round(recording.most_held(1.0, SECONDS) or 0.0, 2), at_least=0.5, at_most=8.9)

    # Leader and robot share no network: each reaches only the server.
    inside = {name: compose.networks_of(name) for name in ("server", "first", "robot")}
    judge.expect("networks", inside, equal={"server": ["hands", "robots"], "first": ["hands"], "robot": ["robots"]})

    lead(compose, "second", SECONDS_CUT)
    compose.up("second")
    time.sleep(OUT_FROM)
    compose.network("disconnect", "robots", "robot")
    time.sleep(OUT_FOR)
    compose.network("connect", "robots", "robot")
    judge.expect("second: exit code", compose.wait("second"), equal=[0])
    told = report(compose.out / "second.json")
    recording = Recording(compose.out / "second.csv")
    expect_passive(judge, "second", told, recording)
    judge.expect("second: disconnections of the hand", told["disconnections"], equal=0)
    judge.expect("second: largest force before [N]", round(recording.most_held(1.0, OUT_FROM) or 0.0, 2), at_least=0.5)
    # Its start and the engine's work shift the time. The robot comes back, and the switch is never released: nothing follows.
    judge.expect("second: largest force without a robot [N]",
                 round(recording.most_held(OUT_FROM + 1.5, SECONDS_CUT) or 0.0, 3), equal=0.0)
    ended = compose.stop("robot", "server")
    judge.expect("robot, server: exit codes at SIGTERM", [code for code, _ in ended.values()], equal=[0, 0])
    robot = report(compose.out / "robot.json")
    judge.expect("robot: end", robot["end"], equal="requested")
    judge.expect("robot: times that it began to follow", robot["engagements"], equal=2)
    judge.expect("robot: followed no longer than it was led", robot["engagements"] - robot["holds"], equal=0)
    judge.expect("robot: sessions, one of them after the cable", robot["sessions"], at_least=2)
    judge.expect("robot: largest force [N]", round(robot["largest_force_n"], 2), at_least=0.5, at_most=25.0)
    judge.expect("robot: targets", robot["targets"], at_least=1000)
