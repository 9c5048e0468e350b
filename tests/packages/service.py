"""Tries the service feltwire-server in a system that systemd has started, and the commands of docs/operations.md: service.py

As root. A hand taps while the service reads its scenes again, is killed, and stops; systemd sees to it and keeps its sandbox.
"""
import os
import pathlib
import pwd
import re
import stat
import subprocess
import time

UNIT = "feltwire-server"
STATE = pathlib.Path("/var/lib/feltwire")
LONGEST = 60.0  # [s]
FELT = 0.3  # [N], the hand taps with more


def failed(text):
    log = subprocess.run(["journalctl", "--no-pager", "--unit", UNIT], capture_output=True, text=True, check=False).stdout
    raise SystemExit(f"{text}\n{log}")


def systemctl(*words):
    done = subprocess.run(["systemctl", *words], capture_output=True, text=True, timeout=LONGEST, check=False)
    if done.returncode != 0:
        failed(f"systemctl {' '.join(words)}: {done.stdout}{done.stderr}")
    return done.stdout.strip()


def value(name):
    return systemctl("show", "--property", name, "--value", UNIT)


def until(what, condition):
    end = time.monotonic() + LONGEST
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.05)
    failed(f"after {LONGEST:.0f} s there is still not: {what}")


class Hand:
    """A hand that taps on the floor of the service's scene, as status lines show it, one a second."""

    def __init__(self):
        command = ["feltwire-client", "--connect", "127.0.0.1:6720", "--scene", "room", "--fingerprint-file", STATE / "fingerprint",
                   "--token-file", STATE / "local.token", "--flight-recorder", "off", "--device", "simulated:path=taps", "--duration", "600"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines = []

    def line(self):
        """The next line that tells a force: the line, and the force [N]."""
        for text in self.process.stdout:
            self.lines.append(text)
            if found := re.search(r"force +([0-9.]+) N", text):
                return text, float(found[1])
        return failed(f"the hand has ended:\n{''.join(self.lines)}")

    def wait_for(self, what, condition):
        end = time.monotonic() + LONGEST
        while not condition(*self.line()):
            if time.monotonic() > end:
                failed(f"the hand shows no {what}:\n{''.join(self.lines)}")

    def feels(self):
        self.wait_for("force", lambda text, force: force > FELT)


def paste(page):
    """Types the commands of a page, one after the other, as root does."""
    outside = "".join(page.read_text(encoding="utf-8").split("```")[::2])  # of fenced blocks, which are no commands
    commands = [line[4:] for line in outside.splitlines() if line.startswith("    ")]
    for command in commands:
        done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=LONGEST, check=False)
        if done.returncode != 0:
            failed(f"{page}: {command}\n{done.stdout}{done.stderr}")
    return len(commands)


def real_time(process):
    """Waits until a thread of the server has real-time priority."""
    limit = re.search(r"Max realtime priority +([0-9]+)", pathlib.Path(f"/proc/{process}/limits").read_text())
    if int(limit[1]) == 0:
        return "no real-time priority: this machine lets systemd raise no limit"
    threads = pathlib.Path(f"/proc/{process}/task")
    until("a thread with real-time priority",
          lambda: any(os.sched_getscheduler(int(thread.name)) == os.SCHED_FIFO for thread in threads.iterdir()))
    return "real-time priority"


def main():
    until("the service is active", lambda: value("ActiveState") == "active")
    until("a fingerprint", (STATE / "fingerprint").exists)
    process = int(value("MainPID"))
    user = pwd.getpwuid(os.stat(f"/proc/{process}").st_uid).pw_name
    mode = stat.S_IMODE(STATE.stat().st_mode)
    if user != "feltwire" or mode != 0o700 or STATE.owner() != "feltwire":
        failed(f"the service runs as {user}; its folder is {STATE.owner()}'s, mode {mode:o}")
    if "NoNewPrivs:\t1" not in pathlib.Path(f"/proc/{process}/status").read_text():
        failed("the service may gain privileges: systemd has not made its sandbox")
    begin = time.monotonic()
    hand = Hand()
    hand.feels()
    print(f"started by systemd as user feltwire, in its sandbox; a hand feels the floor after {time.monotonic() - begin:.1f} s")

    systemctl("reload", UNIT)
    for _ in range(3):
        text, _ = hand.line()
        if "no force" in text and "touches nothing" not in text:
            failed(f"after a reload the hand feels nothing: {text}")
    hand.feels()
    if int(value("MainPID")) != process:
        failed("a reload has started the server anew")
    print("reloaded; the hand felt the floor all the time")

    systemctl("kill", "--signal", "KILL", UNIT)
    hand.wait_for("loss of force", lambda text, force: "no fresh answer" in text)
    until("the service is active again", lambda: value("ActiveState") == "active" and int(value("MainPID")) not in (0, process))
    hand.feels()
    print("killed; systemd started it again, and the same hand feels the floor")

    systemctl("stop", UNIT)
    if value("Result") != "success" or value("ActiveState") != "inactive":
        failed(f"a stop leaves it {value('ActiveState')}, {value('Result')}")
    hand.process.terminate()
    hand.process.wait(LONGEST)
    with open(f"/etc/default/{UNIT}", "a", encoding="utf-8") as options:
        options.write("FELTWIRE_SERVER_REAL_TIME=true\n")
    systemctl("start", UNIT)
    print(f"stopped, and started with {real_time(int(value('MainPID')))}")
    os.environ["HOME"] = pwd.getpwuid(0).pw_dir  # as the shell of an admin has it
    page = pathlib.Path("/usr/share/doc/feltwire-doc/docs/operations.md")
    print(f"{paste(page)} commands of {page} typed")
    if value("ActiveState") != "active":
        failed("after the commands of the page the service is not active")
    exposure = subprocess.run(["systemd-analyze", "security", "--no-pager", UNIT], capture_output=True, text=True, check=True).stdout
    print(exposure.splitlines()[-1].lstrip("→ "))


main()
