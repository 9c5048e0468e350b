"""feltwire-server as a process of its own, with a state folder and tokens that are made for it."""
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path

from control import ROLES, Control

SOURCE = Path(__file__).resolve().parents[2]
LONGEST = 60.0  # [s]


class Server:
    """What the checks need of a server: host, port, scene, fingerprint, tokens by role, and the end."""

    host = "127.0.0.1"
    has = ("changes", "materials", "limits", "models", "surfaces", "tools", "robots", "tokens", "slow", "shapes")
    scenes = ("scenes/plane.json", "scenes/bunny.json", "scenes/mallet.json", "scenes/teleoperation/seat.json",
              "tests/conformance/shapes.json")
    offsets = {"plane": 1, "bunny": 2, "mallet": 3, "seat": 4, "shapes": 5}
    most_sessions = 20
    burst = 200  # of joins, changes and questions: the checks make more of them than a client does
    tokens_of = {  # name -> role, scene
        "observer": ("observer", "*"), "pointer": ("pointer", "*"), "operator": ("operator", "*"), "admin": ("admin", "*"),
        "other": ("operator", "*"), "doomed": ("operator", "*"), "narrow": ("operator", "mallet"), "follower": ("follower", "seat"),
        "follower_elsewhere": ("follower", "plane")}

    def __init__(self, program):
        self.folder = Path(tempfile.mkdtemp(prefix="feltwire-conformance-"))
        self.program, self.tokens = program, {}
        self.scene, self.silence = "plane", None
        state = self.folder / "state"
        state.mkdir(mode=0o700)
        for name, (role, scene) in self.tokens_of.items():
            self.add_token(name, role, scene)
        config = self.folder / "config.json"
        config.write_text(f'{{"max_sessions_per_scene": {self.most_sessions}}}', encoding="utf-8")
        command = [program, "--state", state, "--port", "0", "--log-level", "warning", "--silence-timeout", "4", "--join-burst", str(self.burst), "--config", config]
        for scene in self.scenes:
            command += ["--scene", SOURCE / scene]
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
        subprocess.run([str(self.program), "token", "add", "--state", str(self.folder / "state"), "--client", f"{name}-client", "--scene", scene,
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
        return ROLES[role]

    def control(self, role=None):
        return Control(self, self.token(role) if role else None)

    def begin_silence(self):
        """Opens a connection that shows no token, and notes when the server closes it."""
        control = self.control()
        control.patience(LONGEST)
        begin = time.monotonic()

        def wait():
            self.silence_took = time.monotonic() - begin if control.closes() else None
            control.close()
        self.silence = threading.Thread(target=wait)
        self.silence.start()

    def silent_connection_closed(self):
        """[s] until that connection was closed; None if it was not."""
        self.silence.join()
        return self.silence_took

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
