"""A server that a program starts for itself."""
import pathlib
import re
import subprocess
import tempfile
import threading

from .hand import Error, join
from .library import program


def serve(scene, **options):
    """Starts feltwire-server with a scene file on a free port of this machine, and returns the Server when it listens.

    scene: the path of a scene file, or a list of paths. All other keywords are options of feltwire-server with _ for -:
    web="0". Raises Error with the server's words if it does not start.
    """
    return Server(scene, options)


class Server:
    """A running server with keys of its own. Use it in a `with` block, or call close()."""

    def __init__(self, scenes, options):
        scenes = [scenes] if isinstance(scenes, (str, pathlib.Path)) else list(scenes)
        self._folder = tempfile.TemporaryDirectory(prefix="feltwire-")
        state = pathlib.Path(self._folder.name) / "state"
        command = [program("feltwire-server"), "--port", "0", "--state", str(state)]
        for scene in scenes:
            command += ["--scene", str(scene)]
        for name, value in options.items():
            command += [f"--{name.replace('_', '-')}", str(value)]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.scenes, self.page = [], None
        self.fingerprint_file, self.token_file = str(state / "fingerprint"), str(state / "local.token")
        said, port = [], None
        for line in self._process.stdout:
            said.append(line)
            if listening := re.match(r"listening: control tcp (\d+)", line):
                port = listening[1]
            if page := re.match(r"live page: (\S+)", line):
                self.page = page[1]
            if line.startswith("live page:" if "web" in options else "join:"):
                break
        else:
            self.close()
            raise Error("the server did not start:\n" + "".join(said))
        self.address = f"localhost:{port}"
        self.scenes = re.findall(r"--scene (\S+)", "".join(said)) or [pathlib.Path(one).stem for one in scenes]
        # A pipe that nobody reads would stop the server.
        threading.Thread(target=self._process.stdout.read, daemon=True).start()

    def join(self, scene=None, **options):
        """Joins one of its scenes, the first one if none is named. Keywords as in feltwire.join()."""
        return join(self.address, scene or self.scenes[0], fingerprint_file=self.fingerprint_file, token_file=self.token_file, **options)

    def close(self):
        """Ends the server. May be called again."""
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
