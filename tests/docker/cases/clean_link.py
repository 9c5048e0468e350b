"""Two hands on one table over a clean line: no tick and nothing else lost, both feel it."""

from judge import Recording, expect_honest, expect_undisturbed, report

SECONDS = 6.0
TABLE = -0.05  # [m] height of its top in scenes/room.json


def run(compose, judge):
    compose.server()
    compose.client("left", duration=SECONDS, options=["--device", "simulated:path=slide,center=0,0,-0.05,radius=0.03"])
    compose.client("right", duration=SECONDS, options=["--device", "simulated:path=press,center=0.03,-0.02,-0.05"])
    compose.up("server")
    compose.up("left", "right")
    judge.expect("exit codes", compose.wait("left", "right"), equal=[0, 0])
    hands = {name: report(compose.out / f"{name}.json") for name in ("left", "right")}
    for name, told in hands.items():
        recording = Recording(compose.out / f"{name}.csv")
        expect_undisturbed(judge, name, told, recording)
        pressed = [f for z, f in zip(recording.columns["z"], recording.columns["rz"]) if z < TABLE - 1e-4]
        judge.expect(f"{name}: ticks in the table", len(pressed), at_least=1000)
        judge.expect(f"{name}: mean force upwards there [N]", sum(pressed) / max(1, len(pressed)), at_least=0.5)

    scene = compose.counters()["room"]
    expect_honest(judge, scene)
    judge.expect("sessions that there were", scene["sessions_served"], equal=2)
    judge.expect("sessions that left", scene["left"], equal=2)
    judge.expect("samples answered, server against clients", scene["replies"],
                 at_least=sum(told["answered"] for told in hands.values()))
    judge.expect("samples missed", scene["missed"], equal=0)
    ended = compose.stop("server")
    judge.expect("server: exit code at SIGTERM", ended["server"][0], equal=0)
