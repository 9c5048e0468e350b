#!/usr/bin/env python3
"""Reads what each version of feltwire left with its users (make_release.py) by the programs of today.

Recordings are exported whole and computed again. On the machine of the recording the replies must be the same bit for bit, but for the
sessions in the file `changed.json` beside them, which says why. The server of today runs by the version's configuration and tokens, and
the client by its device file, its plugin, and the movement that it recorded.

usage: check_released.py PROGRAM_FOLDER COMPILER
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from make_release import HERE, Server, finish, machine, run, samples

MOST_CHANGED = 2  # sessions of a version whose bits may differ before this check proves too little: record a new version


def check_recordings(bin_folder, version, folder):
    manifest = json.loads((version / "manifest.json").read_text())
    same_machine = manifest["machine"] == machine(bin_folder)
    changed_file = version / "changed.json"
    changed = json.loads(changed_file.read_text()) if changed_file.exists() else {}
    if len(changed) > MOST_CHANGED:
        sys.exit(f"{changed_file} names {len(changed)} sessions, at most {MOST_CHANGED} may differ")
    for name, counts in manifest["recordings"].items():
        file = version / f"{name}.mcap"
        replay = subprocess.run([bin_folder / "feltwire-lab", "replay", file, "--json"], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        if replay.stderr:
            sys.exit(f"{file}: {replay.stderr}")
        got = json.loads(replay.stdout)
        if same_machine and not got["bit_equal"] and name not in changed:
            sys.exit(f"{file}: {got['verdict']}\nif this is meant, name the session in {changed_file} and say why")
        if got["bit_equal"] and {key: got[key] for key in counts} != counts:
            sys.exit(f"{file}: {counts} were recorded, {got} were read")
        exported = samples(bin_folder, file, folder / name)
        if exported != manifest["samples"][name]:
            sys.exit(f"{file}: {manifest['samples'][name]} samples of hands were exported, {exported} are today")
        print(f"{file.relative_to(HERE)}: {got['verdict']}, {exported} samples")


def check_session(bin_folder, version, compiler, folder):
    """A session by the version's files."""
    shutil.copytree(version, folder, dirs_exist_ok=True)
    for secret in ("tokens.json", "operator.token"):
        (folder / secret).chmod(0o600)
    plugin = folder / "my_plugin.so"
    run(compiler, "-x", "c", "-std=c99", "-shared", "-fPIC", f"-I{folder / 'include'}", folder / "my_plugin.c", "-o", plugin)
    if samples(bin_folder, folder / "hand.mcap", folder / "hand") == 0:
        sys.exit(f"{version / 'hand.mcap'} has no sample")
    movement = folder / "hand/hand_sample.csv"
    with Server(bin_folder, ["--config", folder / "configuration.json"], folder) as server:
        for device in (["--device", "simulated:path=press", "--spec", folder / "device.json"],
                       ["--device", f"plugin:{plugin}:0.2", "--let-go-after", "0.1"],
                       ["--device", f"replay:{movement}"]):
            report = folder / "today.json"
            finish(server.start("feltwire-client", folder / "operator.token", "--scene", "workshop", *device, "--duration", "1",
                                "--no-rehearsal", "--report", report))
            today, then = json.loads(report.read_text()), json.loads((version / "report.json").read_text())
            if today["answered"] == 0:
                sys.exit(f"{device}: no reply came")
            if gone := sorted(set(then) - set(today)):
                sys.exit(f"{version.name} had {gone} in its report, today's has not")
            print(f"{version.name}: {device[1]}, {today['answered']} answers")


def main():
    bin_folder, compiler = Path(sys.argv[1]).resolve(), sys.argv[2]
    versions = sorted(path for path in HERE.glob("[0-9]*.*.*") if path.is_dir())
    if not versions:
        sys.exit(f"no version in {HERE}")
    for version in versions:
        with tempfile.TemporaryDirectory() as made:
            check_recordings(bin_folder, version, Path(made))
        with tempfile.TemporaryDirectory() as made:
            check_session(bin_folder, version, compiler, Path(made))


if __name__ == "__main__":
    main()
