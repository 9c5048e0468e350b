"""Eight hands of five devices (2, 3 and 6 degrees of freedom), four in each of two scenes of one server."""

from judge import Recording, expect_honest, expect_undisturbed, report

SECONDS = 6.0
# name: scene, device, degrees of freedom that it moves in and senses, path
HANDS = {
    "wall-flat-1": ("paper_wall", "impulse_engine_2000", 2, "press"),
    "wall-flat-2": ("paper_wall", "impulse_engine_2000", 2, "slide"),
    "wall-plain": ("paper_wall", "simulated", 3, "press"),
    "wall-phantom": ("paper_wall", "phantom_premium_1.5", 3, "taps"),
    "room-plain": ("room", "simulated", 3, "figure-eight"),
    "room-phantom": ("room", "phantom_premium_1.5", 3, "slide"),
    "room-touch": ("room", "touch", 6, "press"),
    "room-omega": ("room", "omega.7", 6, "slide"),
}


def run(compose, judge):
    compose.server(scenes=["room", "paper_wall"])
    compose.up("server")
    for seed, (name, (scene, spec, _, path)) in enumerate(HANDS.items(), 1):
        compose.client(name, scene=scene, duration=SECONDS, options=[
            "--spec", spec, "--device", f"simulated:path={path},radius=0.01,depth=0.005,seed={seed}"])
    compose.up(*HANDS)
    judge.expect("exit codes", compose.wait(*HANDS), equal=[0] * len(HANDS))

    counters = compose.counters()
    for name, (scene, _, freedom, _) in HANDS.items():
        told = report(compose.out / f"{name}.json")
        expect_undisturbed(judge, name, told, Recording(compose.out / f"{name}.csv"))
        device = told["device"]
        judge.expect(f"{name}: degrees of freedom", device["translation_dof"] + device["rotation_sensed"], equal=freedom)
        judge.expect(f"{name}: scene", told["scene"], equal=scene)
    for scene in ("room", "paper_wall"):
        expect_honest(judge, counters[scene])
        judge.expect(f"scene {scene}: sessions that there were", counters[scene]["sessions_served"], equal=4)
        judge.expect(f"scene {scene}: samples missed", counters[scene]["missed"], equal=0)
        judge.expect(f"scene {scene}: datagrams of no session", counters[scene]["dropped"]["session"], at_most=64)
