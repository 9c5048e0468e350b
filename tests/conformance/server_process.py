"""feltwire-server as a process of its own, with a state folder and tokens that are made for it."""
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

from control import ROLES, Control

SOURCE = Path(__file__).resolve().parents[2]
LONGEST = 60.0  # [s]


class Server:
    """What the checks need of a server: host, port, scene, fingerprint, tokens by role, and the end."""

    host = "127.0.0.1"
    is_model = False
    roles = ("observer", "pointer", "operator", "admin", "other")

    def __init__(self, program, scenes=("scenes/plane.json",), options=(), config=None):
        self.folder = Path(tempfile.mkdtemp(prefix="feltwire-conformance-"))
        self.program, self.tokens = program, {}
        self.scene = Path(scenes[0]).stem
        state = self.folder / "state"
        state.mkdir(mode=0o700)
        for role in self.roles:
            self.add_token(role, "operator" if role == "other" else role, "*")
        command = [program, "--state", state, "--port", "0", "--log-level", "warning", *options]
        for scene in scenes:
            command += ["--scene", SOURCE / scene]
        if config is not None:
            (self.folder / "config.json").write_text(config, encoding="utf-8")
            command += ["--config", self.folder / "config.json"]
        environment = {key: value for key, value in os.environ.items() if not key.startswith("FELTWIRE_")}
        self.log = open(self.folder / "log", "wb")
        self.process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=self.log, text=True, env=environment)
        for line in self.process.stdout:
            if line.startswith("fingerprint: "):
                self.fingerprint = line.split()[1]
            if line.startswith("listening: control tcp "):
                self.port = int(line.split()[3].rstrip(","))
            if line.startswith("join:"):
                break
        else:
            raise RuntimeError("the server did not start: " + (self.folder / "log").read_text())

    def add_token(self, name, role, scene):
        file = self.folder / f"{name}.token"
        client = {"other": "somebody"}.get(name, f"{name}-client")
        subprocess.run([str(self.program), "token", "add", "--state", str(self.folder / "state"), "--client", client, "--scene", scene,
                        "--role", role, "--expires", "never", "--out", str(file)], check=True, stdout=subprocess.PIPE, timeout=LONGEST)
        self.tokens[name] = file.read_text().strip()

    def revoke(self, name):
        identity = self.tokens[name].split("_")[1]
        subprocess.run([str(self.program), "token", "revoke", "--state", str(self.folder / "state"), identity], check=True,
                       stdout=subprocess.PIPE, timeout=LONGEST)

    def token(self, role):
        return self.tokens[role]

    @staticmethod
    def role_number(role):
        return ROLES[{"other": "operator"}.get(role, role)]

    def control(self, role=None):
        return Control(self, self.token(role) if role else None)

    def end(self):
        """Asks the server to end, as Ctrl-C does."""
        self.process.send_signal(signal.SIGTERM)

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(LONGEST)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process.stdout.close()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)
