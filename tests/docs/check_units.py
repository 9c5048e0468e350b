#!/usr/bin/env python3
"""Checks the systemd units of the Debian package: systemd-analyze finds nothing wrong with them, and the template for several servers of a
machine has the sandbox and the limits of the unit for one. Both have every line of HARDENING: a line that is dropped must be dropped here too.

usage: check_units.py SOURCE_FOLDER BIN_FOLDER
"""

import pathlib
import subprocess
import sys
import tempfile

PROGRAM = "/usr/bin/feltwire-server"
# Settings in which the template differs from the unit for one server.
OWN = ("Description=", "EnvironmentFile=", "StateDirectory=", "ExecStart=")
# The sandbox of the service, and the limits that real-time scheduling needs.
HARDENING = """
User=feltwire
StateDirectoryMode=0700
UMask=0077
LimitRTPRIO=80
LimitMEMLOCK=infinity
NoNewPrivileges=yes
CapabilityBoundingSet=
AmbientCapabilities=
ProtectSystem=strict
ProtectHome=yes
PrivateTmp=yes
PrivateDevices=yes
ProtectClock=yes
ProtectControlGroups=yes
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
ProtectProc=invisible
RemoveIPC=yes
RestrictAddressFamilies=AF_INET AF_INET6 AF_UNIX AF_NETLINK
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
MemoryDenyWriteExecute=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallErrorNumber=EPERM
""".split("\n")[1:-1]


def settings(text):
    return [line for line in text.splitlines() if line and not line.startswith(("#", *OWN))]


def main():
    debian, server = pathlib.Path(sys.argv[1]) / "debian", pathlib.Path(sys.argv[2]).resolve() / "feltwire-server"
    units = {name: (debian / name).read_text(encoding="utf-8") for name in ("feltwire-server.service", "feltwire-server@.service")}
    wrong = []
    one, template = (settings(text) for text in units.values())
    wrong += [f"feltwire-server@.service lacks {line}" for line in one if line not in template]
    wrong += [f"feltwire-server.service lacks {line}" for line in template if line not in one]
    wrong += [f"{name} lacks {line}" for name, text in units.items() for line in HARDENING if line not in text.splitlines()]
    for line in units["feltwire-server@.service"].splitlines():
        if line.startswith(OWN) and "%i" not in line:
            wrong.append(f"feltwire-server@.service: all servers would share {line}")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in units.items():
            if PROGRAM not in text:
                wrong.append(f"{name} does not start {PROGRAM}")
            (pathlib.Path(folder) / name).write_text(text.replace(PROGRAM, str(server)), encoding="utf-8")
        done = subprocess.run(["systemd-analyze", "--man=no", "verify", "./feltwire-server.service", "./feltwire-server@room.service"],
                              cwd=folder, capture_output=True, text=True, timeout=60, check=False)
        if done.returncode != 0 or done.stderr.strip():
            wrong.append(f"systemd-analyze verify: exit status {done.returncode}: {done.stderr.strip()}")
    print("\n".join([*wrong, f"{sum(map(len, (one, template)))} settings compared, {len(wrong)} wrong"]))
    return 1 if wrong or not one else 0


if __name__ == "__main__":
    sys.exit(main())
