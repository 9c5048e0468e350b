"""A client as a process of its own: feltwire-client with a simulated hand, or the model client with the same options."""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import patience
from checks import TIMED_OUT, Failure

MODEL = Path(__file__).resolve().parent / "model_client.py"
# The law `none` holds what the server commands, so that what a reply does is seen in the samples behind it.
HAND = ("--mode", "none", "--local-model", "off", "--no-rehearsal", "--ramp-up", "0", "--velocity-limit", "inf",
        "--flight-recorder", "off")
RATE = 200  # [Hz] of the servo, so that a server in Python answers each sample


class Client:
    """What the checks need of a client: to start it. `wrong`: the deviation of a model client."""

    def __init__(self, program=None, wrong=None):
        self.program, self.wrong = program, wrong
        self.folder = Path(tempfile.mkdtemp(prefix="feltwire-conformance-"))

    def start(self, server, *options, duration=0.5, rate=RATE, hold=0.2, reconnect=0, wait="inf", path="slide"):
        words = [self.program] if self.program else [sys.executable, "-B", MODEL, *(["--wrong", self.wrong] if self.wrong else [])]
        file = self.folder / f"{server.port}.token"
        file.write_text(server.token("operator") + "\n", encoding="utf-8")
        file.chmod(0o600)
        words += ["--connect", f"127.0.0.1:{server.port}", "--scene", server.scene, "--token-file", file, "--duration", duration, "--rate", rate,
                  "--hold-time", hold, "--reconnect", reconnect, "--wait-for-small-force", wait, "--device", f"simulated:path={path},depth=0,await_still=0", *HAND, *options]
        if "--fingerprint" not in options:
            words += ["--fingerprint", server.fingerprint]
        environment = {key: value for key, value in os.environ.items() if not key.startswith("FELTWIRE_")}
        environment |= {"HOME": str(self.folder), "XDG_STATE_HOME": str(self.folder)}
        return Run(subprocess.Popen([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                    text=True, env=environment))

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)


class Run:
    """One run of a client."""

    def __init__(self, process):
        self.process, self.output = process, None

    def wait(self):
        """(exit status, what it wrote to stdout and stderr)."""
        if self.output is None:
            try:
                out, err = self.process.communicate(timeout=patience.LONGEST + 10)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.communicate()
                self.output = ""
                raise Failure(f"{TIMED_OUT} {patience.LONGEST + 10} s: the end of the client") from None
            self.output = out + err
        return self.process.returncode, self.output

    def stop(self):
        if self.process.poll() is None:
            self.process.terminate()
        return self.wait()
