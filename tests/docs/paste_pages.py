#!/usr/bin/env python3
"""Pastes the commands of the pages line by line into one shell, as a reader does on a machine of his own, and compares what happens with
what the page says.

Each page has a shell, an empty home folder and a copy of the repository's root (links) as its working folder. Each but the quickstart
begins with the commands of docs/README.md, which say where the programs are. The pages run one after
the other, in the order of the command line: a page may use what an earlier one has left (hand.csv).

Commands are the lines of code blocks that are indented by four spaces, or fenced as sh. Words behind # tell the reader, and this script,
what is special:

  # leave it running           the command runs in a terminal of its own. The next command comes once it is ready
  # Ctrl-C in the server's terminal      (a line of its own; robot's, hand's, relay's, page's) ends it: exit status 0
  # needs the device           there is none here: exit status 1 (or one that is named, too), and a line that begins with the program's name
  # exit status 2              or: exit status 0 or 1. Without such words it is 0
  # takes 5 minutes            not run here, nor is a command that says: on another machine

Code fenced as output stands in the output of the commands before it (numbers equal within rounding); fenced as sample: the same words in
the same order, with any numbers. Three dots stand for any text.

Building is not repeated: cmake is a program that looks whether the named targets are there, and scripts/install-packages does nothing.
Every join: line that a server prints is pasted, too, before the server ends.

Ports: the pages have fixed ones. The script runs in a network of its own (unshare --net). Where the system allows none, the control port
6720 becomes a free one in all commands, and servers get it by FELTWIRE_SERVER_PORT; other ports of the pages become 0 (a free one).

A session in real time ends if the machine leaves its servo standing. Where the program says so, the command is typed again.

usage: paste_pages.py SOURCE_FOLDER BUILD_FOLDER SCRATCH_FOLDER PAGE...
"""

import fcntl
import math
import os
import pathlib
import re
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time

sys.dont_write_bytecode = True  # no files beside the sources
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from stalled import MOST_STALLS, stalled  # noqa: E402

LONGEST = 240.0  # [s] that a command may take
READY = {"feltwire-server": "join: ", "feltwire-follower": "has the robot's seat", "feltwire-lab": "relaying: ",
         "feltwire-view": "live page: ", "feltwire-client": "round trip"}
TERMINALS = {"server": "feltwire-server", "robot": "feltwire-follower", "hand": "feltwire-client", "relay": "feltwire-lab",
             "page": "feltwire-view"}
SHIM = """#!/bin/sh
# In place of cmake: what is built is there already.
while [ $# -gt 0 ]; do
  case $1 in
    --target) shift; for one; do case $one in -*) break ;; esac
      [ -x "{bin}/$one" ] || [ -n "$(find -L "{build}/tests" "{build}/examples" -name "$one" -type f -perm -u+x 2>/dev/null | head -1)" ] ||
        {{ echo "$one is not built" >&2; exit 1; }}; done ;;
  esac
  shift
done
"""


class Wrong(Exception):
    pass


class Command:
    def __init__(self, number, text):
        self.number, self.text = number, text
        said = re.search(r"(?:^|\s)#\s*(.*)$", text.split("\n")[-1])
        self.said = said.group(1) if said else ""

    def statuses(self):
        named = re.search(r"exit status (\d+)(?: or (\d+))?", self.said)
        named = {int(status) for status in named.groups() if status} if named else set()
        return named | {1} if "needs the device" in self.said else named or {0}

    def left_out(self):
        minutes = re.search(r"takes (\d+) minutes", self.said)
        return bool(minutes and int(minutes.group(1)) > 1) or "on another machine" in self.said


class Expected:
    def __init__(self, number, kind, lines):
        self.number, self.exact, self.lines = number, kind == "output", lines


def steps(path):
    """The commands of a page, and what it says of their output, in its order."""
    fence, block, begun, text = None, [], 0, ""
    for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
        stripped = line.strip()
        if stripped.startswith("```"):
            if fence is None:
                fence, block, begun_block = stripped[3:].split(" ")[0], [], number
            else:
                if fence in ("output", "sample"):
                    yield Expected(begun_block, fence, block)
                fence = None
            continue
        if fence in ("output", "sample"):
            block.append(line)
        shell = fence in ("sh", "bash", "shell") or (fence is None and line.startswith("    "))
        if not shell or not stripped:
            continue
        begun = begun or number
        text += ("\n" if text else "") + stripped
        if stripped.endswith("\\"):
            continue
        yield Command(begun, text)
        begun, text = 0, ""


def number_of(word):
    try:
        return float(word)
    except ValueError:
        return None


def same_line(said, seen, exact):
    """Whether an output line is the one that the page shows."""
    parts = re.split(r"([-+]?\d[\d.]*(?:e[-+]?\d+)?)", said)
    pattern = "".join(r"([-+]?\d[\d.]*(?:e[-+]?\d+)?)" if i % 2 else
                      r"\s+".join(re.escape(word) for word in re.split(r"\s+", part)).replace(r"\.\.\.", ".*")
                      for i, part in enumerate(parts))
    found = re.search(pattern, seen) if not exact else re.fullmatch(r"\s*" + pattern + r"\s*", seen)
    if not found:
        return False
    numbers = zip(parts[1::2], found.groups())
    return not exact or all(math.isclose(float(a.rstrip(".")), float(b.rstrip(".")), rel_tol=1e-9, abs_tol=1e-9) for a, b in numbers)


def compare(expected, output):
    """All its lines stand in the output, in their order. Throws Wrong."""
    lines = iter(output.split("\n"))
    for said in expected.lines:
        if said.strip() and not any(same_line(said.strip(), seen.strip(), expected.exact) for seen in lines):
            raise Wrong(f"the page shows '{said.strip()}', and the commands before it printed:\n{output[-3000:]}")


def runs(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


class Shell:
    def __init__(self, folder, environment):
        self.folder = folder
        self.bash = subprocess.Popen(["bash", "--noprofile", "--norc"], cwd=folder, env=environment, stdin=subprocess.PIPE,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        self.bash.stdin.write(b"set -m\n")
        self.running = []  # (program, process number, file of its output), the newest last

    def say(self, line):
        """Types one line, and returns the word that the shell answers."""
        self.bash.stdin.write(line.encode() + b"\n")
        self.bash.stdin.flush()
        deadline, answer = time.monotonic() + LONGEST, b""
        while not answer.endswith(b"\n"):
            ready, _, _ = select.select([self.bash.stdout], [], [], max(0.0, deadline - time.monotonic()))
            if not ready:
                raise Wrong(f"no end within {LONGEST:.0f} s")
            more = os.read(self.bash.stdout.fileno(), 1)
            if not more:
                raise Wrong("the shell has ended")
            answer += more
        return answer.decode().strip()

    def run(self, text):
        """(exit status, output) of a command."""
        file, out = self.folder / ".pasted", self.folder / ".output"
        file.write_text(text + "\n")
        status = self.say('. ./.pasted </dev/null >.output 2>&1; echo "$?"')
        return int(status), out.read_text(encoding="utf-8", errors="replace")

    def leave_running(self, text):
        program = next((word for word in READY if re.search(rf"(^|/|\s){word}\s", text)), None)
        if program is None:
            raise Wrong("it is not known when this program is ready")
        out = self.folder / f".running-{len(self.running)}-{time.monotonic_ns()}"
        out.touch()
        (self.folder / ".pasted").write_text(re.sub(r"\s#\s.*$", "", text) + f' </dev/null >{out.name} 2>&1 &\n')
        process = int(self.say('. ./.pasted; echo "$!"'))
        self.running.append((program, process, out))
        deadline = time.monotonic() + LONGEST
        while READY[program] not in out.read_text(encoding="utf-8", errors="replace"):
            if not runs(process):
                self.running.pop()
                raise Wrong(f"it has ended:\n{out.read_text(encoding='utf-8', errors='replace')}")
            if time.monotonic() > deadline:
                raise Wrong(f"it is not ready after {LONGEST:.0f} s:\n{out.read_text(encoding='utf-8', errors='replace')}")
            time.sleep(0.02)
        return out.read_text(encoding="utf-8", errors="replace")

    def paste_join_line(self, out):
        """The line that a server prints joins it, in the shell of the page."""
        line = re.search(r"^join: (.*)$", out.read_text(encoding="utf-8"), re.M)
        status, said = self.run(line.group(1) + " --duration 0.2")
        if status != 0:
            raise Wrong(f"the printed line\n{line.group(1)}\nends with {status}:\n{said}")

    def interrupt(self, program):
        """Ends the newest program of that name as Ctrl-C does, with exit status 0."""
        found = [one for one in self.running if one[0] == program]
        if not found:
            raise Wrong(f"no {program} runs that could be ended")
        _, process, out = found[-1]
        self.running.remove(found[-1])
        try:
            if program == "feltwire-server":
                self.paste_join_line(out)
        finally:
            os.killpg(process, signal.SIGINT)
            status = int(self.say(f'wait {process}; echo "$?"'))
        if status != 0:
            raise Wrong(f"{program} ends with {status}:\n{out.read_text(encoding='utf-8', errors='replace')}")

    def end(self):
        for _, process, _ in reversed(self.running):
            try:
                os.killpg(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.bash.stdin.close()
        self.bash.wait(timeout=10)


def lay_out(source, build, scratch):
    """A folder that looks like the root of the repository, in which a page may write."""
    root = scratch / "feltwire"
    root.mkdir(parents=True)
    for entry in source.iterdir():
        if entry.name not in ("build", ".git", "scripts"):
            (root / entry.name).symlink_to(entry)
    (root / "scripts").mkdir()
    for script in (source / "scripts").iterdir():
        if script.name != "install-packages":
            (root / "scripts" / script.name).symlink_to(script)
    (root / "scripts" / "install-packages").write_text("#!/bin/sh\n")
    (root / "scripts" / "install-packages").chmod(0o755)
    (root / "build").mkdir()
    (root / "build" / "release").symlink_to(build)
    shims = scratch / "shims"
    shims.mkdir()
    (shims / "cmake").write_text(SHIM.format(bin=build / "bin", build=build))
    (shims / "cmake").chmod(0o755)
    return root, shims


def free_port():
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


def paste(page, source, shell, port):
    """Yields what is wrong, and the number of commands at the end."""
    count, output = 0, ""
    for step in steps(source / page):
        where = f"{page}:{step.number}: "
        try:
            if isinstance(step, Expected):
                compare(step, output)
                output = ""
                continue
            if step.left_out():
                continue
            ended = re.match(r"#\s*Ctrl-C in the (\w+)'s terminal", step.text)
            if step.text.startswith("#") and not ended:
                continue
            count += 1
            text = step.text
            if port:  # no network of its own
                text = re.sub(r"\b6720\b", str(port), text)
                text = re.sub(r"(--web|--listen) (\S*:)?\d{4,}", r"\1 \g<2>0", text)
            begun = time.monotonic()
            if ended:
                shell.interrupt(TERMINALS[ended.group(1)])
                continue
            if "leave it running" in step.said:
                output += shell.leave_running(text)
            else:
                status, said = shell.run(text)
                for _ in range(MOST_STALLS):
                    if status in step.statuses() or not stalled(said):
                        break
                    print(f"{where}this machine had no time for it; once more", flush=True)
                    status, said = shell.run(text)
                output += said
                if status not in step.statuses():
                    raise Wrong(f"{step.text}\nends with {status}, and the page says {sorted(step.statuses())}:\n{said}")
                program = re.match(r"(?:\S*/)?(feltwire-\w+)", text)
                if "needs the device" in step.said and program and not re.search(rf"^{program.group(1)}", said, re.M):
                    raise Wrong(f"{step.text}\nsays nothing of the device:\n{said}")
            print(f"{where}{time.monotonic() - begun:6.1f} s  {step.text.splitlines()[0]}", flush=True)
        except Wrong as wrong:
            yield where + str(wrong)
    for program, _, _ in list(reversed(shell.running)):
        try:
            shell.interrupt(program)
        except Wrong as wrong:
            yield f"{page}: at its end: {wrong}"
    if count == 0:
        yield f"{page}: no command was found: the test reads nothing"


def own_network(arguments):
    """Starts this script anew in a network of its own, if the system allows it."""
    if os.environ.get("FELTWIRE_OWN_NETWORK") or not shutil.which("unshare"):
        return
    if subprocess.run(["unshare", "-rn", "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0:
        os.environ["FELTWIRE_OWN_NETWORK"] = "yes"
        os.execvp("unshare", ["unshare", "-rn", sys.executable, *arguments])


def raise_loopback():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        up = struct.pack("16sh", b"lo", 1)  # IFF_UP
        fcntl.ioctl(any_socket, 0x8914, up)  # SIOCSIFFLAGS


def main():
    own_network(sys.argv)
    alone = os.environ.pop("FELTWIRE_OWN_NETWORK", "") == "yes"
    if alone:
        raise_loopback()
    source, build, scratch = (pathlib.Path(name).resolve() for name in sys.argv[1:4])
    shutil.rmtree(scratch, ignore_errors=True)
    root, shims = lay_out(source, build, scratch)
    wrong = []
    for page in sys.argv[4:]:
        home = scratch / ("home-" + pathlib.Path(page).stem)
        home.mkdir()
        port = 0 if alone else free_port()
        environment = {"PATH": f"{shims}:/usr/local/bin:/usr/bin:/bin:{pathlib.Path(sys.executable).parent}", "HOME": str(home), "LANG": "C.UTF-8", "TERM": "dumb",
                       "PYTHONDONTWRITEBYTECODE": "1",  # tests/ is that of the source
                       **({"FELTWIRE_SERVER_PORT": str(port)} if port else {})}
        shell = Shell(root, environment)
        try:
            if pathlib.Path(page).name != "quickstart.md":
                wrong += paste("docs/README.md", source, shell, port)
            wrong += paste(page, source, shell, port)
        finally:
            shell.end()
    print("\n".join(wrong))
    print(f"{len(wrong)} commands of the pages do something else than they say")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
