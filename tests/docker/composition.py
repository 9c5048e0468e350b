"""Compositions of containers: written as files that Docker Compose takes, started, disturbed and ended."""

import calendar
import json
import os
import pathlib
import shutil
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
IMAGE = os.environ.get("FELTWIRE_IMAGE", "feltwire")
CONTROL_PORT = 6720
STOP_TIME = 2.0  # [s] in which SIGTERM ends every program
# Docker asks the world for the name of a container that is gone; from an internal network it waits for that in vain.
NAMES_THAT_ARE_GONE = ["timeout:1", "attempts:1"]
# The server makes its certificate, and a token for whoever may read this folder.
STATE = "/out/state"
TRUST = ["--fingerprint-file", f"{STATE}/fingerprint", "--token-file", f"{STATE}/local.token"]


def engine(*arguments, check=True, timeout=120):
    """What `docker ARGUMENTS` prints."""
    done = subprocess.run(["docker", *arguments], capture_output=True, text=True, timeout=timeout)
    if check and done.returncode != 0:
        raise RuntimeError(f"docker {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout.strip()


def compose_program():
    """Docker Compose 2 where it is there, else 1; None without either."""
    try:
        if subprocess.run(["docker", "compose", "version"], capture_output=True).returncode == 0:
            return ["docker", "compose"]
    except FileNotFoundError:
        return None
    return ["docker-compose"] if shutil.which("docker-compose") else None


def caller(project, *files, timeout=180, **environment):
    """For a composition that is shipped: a function that is `docker compose ARGUMENTS` with these files, and returns what it prints."""
    def call(*arguments):
        done = subprocess.run(
            [*compose_program(), "-p", project, *(word for file in files for word in ("-f", str(file))), *arguments],
            capture_output=True, text=True, timeout=timeout, env={**os.environ, "FELTWIRE_IMAGE": IMAGE, **environment})
        if done.returncode != 0:
            raise RuntimeError(f"compose {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout + done.stderr
    return call


def wait_until(what, condition, seconds):
    """Asks again and again; the answer, as soon as it is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = condition()
        if answer:
            return answer
        time.sleep(0.05)
    raise RuntimeError(f"waited {seconds:g} s in vain for {what}")


class Composition:
    """Services and networks of one test. `folder` is the containers' /out and gets all that is worth keeping."""

    def __init__(self, name, folder):
        self.project = f"feltwire-{name.replace('_', '-')}"
        self.folder = folder
        self.out = folder / "out"
        self.services = {}
        self.networks = set()
        self.file = folder / "composition.json"
        self.up_before = False
        self.out.mkdir(parents=True)
        os.chmod(self.out, 0o777)  # the image's user is nobody here
        self.remove_leftovers()

    # --- what there is -------------------------------------------------------------------------------------------

    def service(self, name, command, networks, in_network=None, **more):
        self.networks.update(networks)
        self.services[name] = {
            "image": IMAGE, "command": command, "networks": {network: in_network or {} for network in networks},
            "read_only": True, "cap_drop": ["ALL"], "security_opt": ["no-new-privileges:true"],
            "dns_opt": NAMES_THAT_ARE_GONE, "volumes": [f"{self.out}:/out"], **more}
        return name

    def server(self, name="server", scenes=("room",), networks=("line",), alias=None, options=()):
        """Scenes of the image by name, or files in /out."""
        files = [s if s.startswith("/") else f"scenes/{s}.json" for s in scenes]
        command = ["feltwire-server", "--state", STATE, "--summary", f"/out/{name}.json", *options]
        for file in files:
            command += ["--scene", file]
        return self.service(
            name, command, networks, in_network={"aliases": [alias]} if alias else None)

    def client(self, name, scene="room", to="server", networks=("line",), duration=0, options=(), trust=TRUST):
        """A simulated hand with a report and a recording; without a duration it runs until it is stopped."""
        return self.service(name, [
            "feltwire-client", "--connect", f"{to}:{CONTROL_PORT}", "--scene", scene, "--name", name,
            *trust, "--duration", f"{duration:g}", "--report", f"/out/{name}.json", "--record", f"/out/{name}.csv",
            *options], networks)

    def link(self, items, name="link", to="server", networks=("hands", "line")):
        """The link emulator between two networks."""
        return self.service(
            name, ["feltwire-lab", "link", items, "--address", "0.0.0.0", "--listen", str(CONTROL_PORT),
                   "--to", f"{to}:{CONTROL_PORT}", "--report", f"/out/{name}.json"], networks)

    # --- what happens to it --------------------------------------------------------------------------------------

    def compose(self, *arguments, timeout=120):
        done = subprocess.run(
            [*compose_program(), "-p", self.project, "-f", str(self.file), *arguments],
            capture_output=True, text=True, timeout=timeout)
        if done.returncode != 0:
            raise RuntimeError(f"compose {' '.join(arguments)}: {done.stderr.strip()}")

    def up(self, *names):
        """Starts services, at the same time, and waits until servers and links are healthy."""
        self.file.write_text(json.dumps({
            "services": self.services,
            "networks": {name: {"internal": True} for name in sorted(self.networks)}}, indent=1))
        self.compose("up", "-d", "--no-deps", "--no-recreate", *names)
        self.up_before = True
        for name in names:
            program, what = self.services[name]["command"][:2]
            if program in ("feltwire-server", "feltwire-lab") and what != "token":
                wait_until(f"{name} to be healthy", lambda: self.healthy(name), 30)

    def remove_leftovers(self):
        """Containers of a run that was killed: a composition would take them, with another folder, for its own."""
        left = engine("ps", "-aq", "--filter", f"label=com.docker.compose.project={self.project}").split()
        if left:
            engine("rm", "--force", *left)

    def healthy(self, name):
        """Asked once: an engine that asks every second takes the processor from the hands every second."""
        return subprocess.run(["docker", "exec", self.container(name), "feltwire-server", "--health"],
                              capture_output=True, timeout=60).returncode == 0

    def container(self, name):
        return engine("ps", "-aq", "--filter", f"label=com.docker.compose.project={self.project}",
                      "--filter", f"label=com.docker.compose.service={name}")

    def state(self, name):
        return json.loads(engine("inspect", "--format", "{{json .State}}", self.container(name)))

    def running(self, name):
        return self.state(name)["Running"]

    def ended_at(self, name):
        """[s] the time of the engine's clock at which it ended; how long we take to see it does not count."""
        whole, _, fraction = self.state(name)["FinishedAt"].rstrip("Z").partition(".")
        return calendar.timegm(time.strptime(whole, "%Y-%m-%dT%H:%M:%S")) + float(f"0.{fraction or 0}")

    def wait(self, *names, seconds=60):
        """Until these have ended by themselves; their exit codes."""
        return [int(engine("wait", self.container(name), timeout=seconds)) for name in names]

    def logs(self, name):
        done = subprocess.run(["docker", "logs", self.container(name)], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=60)
        return done.stdout

    def act(self, action, name, *options):
        """docker ACTION on the container of a service: kill, pause, unpause, start, stop."""
        engine(action, *options, self.container(name))

    def network(self, action, network, name):
        """docker network connect or disconnect."""
        engine("network", action, f"{self.project}_{network}", self.container(name))

    def networks_of(self, name):
        """The networks that a container is in, as the composition names them."""
        networks = json.loads(engine("inspect", "--format", "{{json .NetworkSettings.Networks}}", self.container(name)))
        return sorted(network.removeprefix(f"{self.project}_") for network in networks)

    def counters(self, server="server"):
        """What a running server has counted up to now, by scene."""
        file = self.out / f"{server}.json"
        before = file.stat().st_mtime_ns
        self.act("kill", server, "--signal", "USR1")
        wait_until(f"the counters of {server}", lambda: file.stat().st_mtime_ns != before, 5)
        return {scene["scene"]: scene for scene in json.loads(file.read_text())["scenes"]}

    def stop(self, *names):
        """Ends what runs with SIGTERM. By service: exit code, and its time [s]."""
        ended = {}
        for name in names:
            begin = time.time()
            self.act("kill", name, "--signal", "TERM")
            wait_until(f"{name} to end", lambda: not self.running(name), 10)
            ended[name] = (self.state(name)["ExitCode"], self.ended_at(name) - begin)
        return ended

    def end(self):
        """Whatever there still is: its logs into the folder, then away with it."""
        if not self.up_before:
            return
        for name in self.services:
            if self.container(name):
                (self.folder / f"{name}.log").write_text(self.logs(name))
        self.compose("down", "-t", "0", "--volumes")
