"""docker/compose.yml as it is shipped: comes up, prints the hands' reports, and ends within two seconds of SIGTERM."""

import time

import composition

FILE = composition.ROOT / "docker/compose.yml"
PROGRAMS = ["server", "link"]  # that run on when the hands are done


def run(compose, judge):
    call = composition.caller(compose.project, FILE, FELTWIRE_DEMO_SECONDS="5", FELTWIRE_DEMO_LINK="lan")
    try:
        call("up", "-d", "--no-build")
        judge.expect("summary: exit code", compose.wait("summary"), equal=[0])
        told = compose.logs("summary")
        judge.expect("the summary has both hands", "left-hand" in told and "right-hand" in told, equal=True)
        broken = next((line for line in told.splitlines() if "energy bound was broken" in line), "")
        judge.expect("times the energy bound was broken", broken.split()[-2:], equal=["0", "0"])
        for name in PROGRAMS:
            inside = composition.engine("inspect", "--format",
                                        "{{.Config.User}} {{.HostConfig.ReadonlyRootfs}} {{.HostConfig.CapDrop}}", compose.container(name))
            judge.expect(f"{name}: user, read-only root, capabilities dropped", inside, equal="feltwire true [ALL]")
        # Once more, and everything ended at full speed.
        call("up", "-d", "--no-build", "left-hand", "right-hand")
        time.sleep(1.5)
        everything = [*PROGRAMS, "left-hand", "right-hand"]
        running = [name for name in everything if compose.running(name)]
        judge.expect("services that run", running, equal=everything)
        composition.engine("kill", "--signal", "TERM", *(compose.container(name) for name in everything))
        composition.wait_until("the end of all", lambda: not any(compose.running(name) for name in everything), 10)
        for name in everything:
            judge.expect(f"{name}: exit code", compose.state(name)["ExitCode"], equal=0)
    finally:
        (compose.folder / "compose.log").write_text(call("logs", "--no-color"))
        call("down", "-t", "0", "--volumes")
