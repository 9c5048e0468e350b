#!/usr/bin/env python3
"""Writes the files that a version of feltwire leaves with its users into a new folder here, which check_released.py reads later.

Run it once for each version, before its tag: seven sessions over loopback with simulated hands, which take some 20 seconds.

usage: make_release.py PROGRAM_FOLDER SOURCE_FOLDER
"""

import json
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LONGEST = 60.0  # [s] that a program may take to say that it is ready
HERE = Path(__file__).resolve().parent
PRESS = ["--device", "simulated:path=press", "--duration", "1"]
# Name: scene, options of the hand.
SESSIONS = {
    "mesh": ("bunny", ["--device", "simulated:path=slide", "--duration", "1"]),
    "bodies": ("workshop", PRESS),
    "tool": ("body", PRESS),
    "deadbands": ("plane", [*PRESS, "--traffic", "position_deadband=2,force_deadband=5"]),
    "observer": ("plane", PRESS),
    "reload": ("plane", ["--device", "simulated:path=press", "--duration", "1.5"]),
    "robot": ("teleoperation/seat", ["--device", "simulated:path=taps,center=0,0,0.3", "--lead", "0.3", "--duration", "2.5"]),
}


class Server:
    """A server with these options and everything in a folder of its own; it stops at the end of the block."""

    def __init__(self, bin_folder, options, folder):
        self.bin, self.folder, self.state = bin_folder, folder, folder / "state"
        self.out = folder / "server.out"
        with open(self.out, "w") as stream:
            self.process = subprocess.Popen([bin_folder / "feltwire-server", "--port", "0", "--state", self.state, *options],
                                            stdout=stream, stderr=subprocess.STDOUT)

    def __enter__(self):
        self.port = self.said(r"control tcp (\d+)")
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        if self.process.wait() != 0:
            sys.exit(f"the server failed:\n{self.out.read_text()}")

    def said(self, pattern):
        until = time.monotonic() + LONGEST
        while time.monotonic() < until and self.process.poll() is None:
            if found := re.search(pattern, self.out.read_text()):
                return found[1]
            time.sleep(0.02)
        sys.exit(f"the server did not say {pattern}:\n{self.out.read_text()}")

    def token(self, role, scene="*"):
        """A file with a token of this role."""
        file = self.folder / f"{role}.token"
        run(self.bin / "feltwire-server", "token", "add", "--state", self.state, "--client", role, "--scene", scene, "--role", role,
            "--expires", "36500d", "--out", file)
        return file

    def start(self, program, token, *options):
        return subprocess.Popen([self.bin / program, "--connect", f"localhost:{self.port}", "--token-file", token,
                                 "--fingerprint-file", self.state / "fingerprint", *options],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def run(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def machine(bin_folder):
    """On what the last bits of a reply depend: the build, the C library and the processor."""
    build = run(bin_folder / "feltwire-lab", "--version").split(maxsplit=3)[3].strip()
    processor = Path("/proc/cpuinfo").read_text()
    widest = next((flag for flag in ("avx512f", "avx2", "avx") if re.search(rf"\b{flag}\b", processor)), "none")
    return f"{build}; {' '.join(platform.libc_ver())}; {platform.machine()} {widest}"


def finish(process):
    out, _ = process.communicate()
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, process.args))}\nended with {process.returncode}:\n{out}")


def samples(bin_folder, file, folder):
    """How many samples of hands a recording has, exported as CSV files into this folder."""
    run(bin_folder / "feltwire-lab", "export", file, "--csv", folder)
    return sum(len(table.read_text().splitlines()) - 1 for table in folder.glob("hand*_sample.csv"))


def record(name, bin_folder, source, target):
    scene, options = SESSIONS[name]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for file in (source / "scenes" / scene).parent.iterdir():
            if file.is_file():
                shutil.copy(file, folder)
        scene_file = folder / f"{Path(scene).name}.json"
        with Server(bin_folder, ["--scene", scene_file, "--record", folder / "server.mcap"], folder) as server:
            scene_name = ["--scene", Path(scene).name]
            beside = []
            if name == "robot":
                token = server.token("follower", Path(scene).name)
                beside.append(server.start("feltwire-follower", token, *scene_name, "--at", "0,0,0.003",
                                           "--surroundings", source / "scenes/teleoperation/surroundings.json"))
            if name == "observer":
                beside.append(server.start("feltwire-client", server.token("observer"), *scene_name, "--role", "observer",
                                           "--view", folder / "seen.csv", "--duration", "1"))
            hand = server.start("feltwire-client", server.token("operator"), *scene_name, *options, "--no-rehearsal",
                                "--record", folder / "hand.mcap", "--report", folder / "report.json")
            if name == "reload":
                server.said(r"(operator).* joined scene")
                time.sleep(0.7)
                text = scene_file.read_text()
                changed = re.sub(r'"stiffness": *[0-9.]+', '"stiffness": 777', text)
                if changed == text:
                    sys.exit(f"{scene_file} has no stiffness to change")
                scene_file.write_text(changed)
                server.process.send_signal(signal.SIGHUP)
            finish(hand)
            for process in beside:
                if name == "robot":
                    process.send_signal(signal.SIGINT)
                finish(process)
        shutil.copyfile(folder / "server.mcap", target / f"{name}.mcap")
        if name == "bodies":  # check_released.py goes on with the files of this session
            for file in ("hand.mcap", "report.json", "workshop.json", "operator.token", "state/tokens.json"):
                shutil.copyfile(folder / file, target / Path(file).name)
        replay = json.loads(run(bin_folder / "feltwire-lab", "replay", folder / "server.mcap", "--json"))
        if not replay["bit_equal"]:
            sys.exit(f"{name}: {replay['verdict']}")
        return replay, samples(bin_folder, folder / "server.mcap", folder / "tables")


def main():
    bin_folder, source = (Path(argument).resolve() for argument in sys.argv[1:3])
    version = run(bin_folder / "feltwire-server", "--version").split()[1]
    target = HERE / version
    target.mkdir()
    recordings, exported = {}, {}
    for name in SESSIONS:
        replay, exported[name] = record(name, bin_folder, source, target)
        recordings[name] = {key: replay[key] for key in ("sessions", "events", "replies", "ticks")}
        print(f"{name}: {recordings[name]}, {(target / f'{name}.mcap').stat().st_size} bytes")
    manifest = {"machine": machine(bin_folder), "recordings": recordings, "samples": exported}
    (target / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n")
    shutil.copy(source / "core/device/sigma_7.json", target / "device.json")
    include = target / "include/feltwire/client/drivers/plugin"
    include.mkdir(parents=True)
    shutil.copy(source / "client/drivers/plugin/feltwire_device_v1.h", include)
    shutil.copy(source / "examples/my_plugin.c", target)
    print(f"write {target / 'configuration.json'} with every option of server/app/config_options.cpp")


if __name__ == "__main__":
    main()
