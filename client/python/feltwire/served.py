"""A server that a program starts for itself."""
from __future__ import annotations

import collections
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import weakref
import webbrowser
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Union

from .errors import Error
from .library import program, scene_file
from .options import words
from .scenes import Scene

if TYPE_CHECKING:
    from .admins import Admin
    from .follower import Follower
    from .hand import Hand
    from .observer import Observer

SceneSource = Union[str, "os.PathLike[str]", Scene]


def serve(scene: Union[SceneSource, Sequence[SceneSource]], **options: Any) -> "Server":
    """Starts feltwire-server with a scene on a free port of this machine, and returns the Server when it listens.

    scene: the path of a scene file, the name of a scene that came with the server ("plane"), a Scene, or a list of these. All other
    keywords are options of feltwire-server with _ for -: web="0", record="room.mcap", real_time=True; a list repeats the option. Raises
    FileNotFoundError if there is no scene of that name, and Error with the server's words if it does not start.
    """
    return Server(scene, options)


def play(scene: Union[SceneSource, Sequence[SceneSource]], *, open_browser: bool = True, **options: Any) -> "Server":
    """Starts a server with the live page (docs/live_page.md), and opens the page in the browser. Returns the Server.

    Prints the page's link. On a terminal it has the token in it, with which everyone on this machine who has the link may hold a hand;
    elsewhere, as in a file or a notebook, it has not: Server.link is the whole link. Keywords and errors as in serve().
    """
    server = Server(scene, {"web": "0", **options})
    print(f"live page: {server.link if sys.stdout.isatty() else server.page}", flush=True)
    if open_browser:
        webbrowser.open(server.door())
    return server


def _end(process: "subprocess.Popen[str]") -> None:
    process.terminate()
    process.wait()


class Server:
    """A running server with keys of its own. Use it in a `with` block, or call close().

    address: "localhost:PORT" of its control port. scenes: the names of its scenes. page: the address of its live page, or None.
    fingerprint_file, token_file: what a client needs. process: its process.
    """

    def __init__(self, scenes: Union[SceneSource, Sequence[SceneSource]], options: Dict[str, Any]):
        sources: List[SceneSource] = [scenes] if isinstance(scenes, (str, os.PathLike, Scene)) else list(scenes)
        self._folder = tempfile.TemporaryDirectory(prefix="feltwire-")
        folder = pathlib.Path(self._folder.name)
        state = folder / "state"
        command = [program("feltwire-server"), "--port", "0", "--state", str(state)]
        for number, scene in enumerate(sources):
            if isinstance(scene, Scene):
                own = folder / str(number)
                own.mkdir()
                scene = scene.place(own)
            command += ["--scene", scene_file(scene)]
        self.process = subprocess.Popen(command + words(options, repeat=True), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                        start_new_session=True)  # Ctrl-C is for the program
        self._finalizer = weakref.finalize(self, _end, self.process)  # a server that nobody closes ends with the program
        assert self.process.stdout is not None
        self._drain: Optional[threading.Thread] = None
        self.scenes: List[str] = []
        self.page: Optional[str] = None
        self.fingerprint_file, self.token_file = str(state / "fingerprint"), str(state / "local.token")
        said: List[str] = []
        port = ""
        for line in self.process.stdout:
            said.append(line)
            if listening := re.match(r"listening: control tcp (\d+)", line):
                port = listening[1]
                self.scenes = re.findall(r", scene (.*?) udp \d+", line)
            if page := re.match(r"live page: (\S+)", line):
                self.page = page[1]
            if line.startswith("live page:" if options.get("web") is not None else "join:"):
                break
        else:
            self.close()
            raise Error("the server did not start:\n" + "".join(said))
        self.address = f"localhost:{port}"
        # A pipe that nobody reads would stop the server. Nothing of it is kept.
        self._drain = threading.Thread(target=collections.deque, args=(self.process.stdout, 0), daemon=True)
        self._drain.start()

    @property
    def link(self) -> str:
        """The link of the live page with the token in it. Keep it as confidential as the token. Raises ValueError without a page."""
        if self.page is None:
            raise ValueError("the server has no live page; start it with web=\"0\", or by feltwire.play()")
        return f"{self.page}#token={pathlib.Path(self.token_file).read_text(encoding='utf-8').strip()}"

    def door(self) -> str:
        """The address of a file that leads to the live page. Only this user may read it: a browser's command line, which other users of this
        machine can see, has no token then. Raises ValueError without a page."""
        path = pathlib.Path(self._folder.name) / "page.html"
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="utf-8") as file:
            file.write(f'<!doctype html><meta http-equiv="refresh" content="0;url={self.link}">')
        return path.as_uri()

    def join(self, scene: Optional[str] = None, **options: Any) -> "Hand":
        """Joins one of its scenes, the first one if none is named. Keywords and errors as in feltwire.join()."""
        self._require_open()
        from .hand import join  # A program that only serves does not need the library.
        return join(self.address, scene or self.scenes[0], fingerprint_file=self.fingerprint_file, token_file=self.token_file, **options)

    def observe(self, scene: Optional[str] = None, **options: Any) -> "Observer":
        """Observes one of its scenes, the first one if none is named. Keywords as in feltwire.observe()."""
        self._require_open()
        from .observer import observe
        return observe(self.address, scene or self.scenes[0], fingerprint_file=self.fingerprint_file, token_file=self.token_file, **options)

    def admin(self) -> "Admin":
        """An Admin of this server, with a token of its own."""
        self._require_open()
        from .admins import admin
        return admin(self.address, fingerprint_file=self.fingerprint_file, token_file=self._token("admin", "*"))

    def follow(self, scene: Optional[str] = None, **options: Any) -> "Follower":
        """Takes the seat of a robot in one of its scenes, the first one if none is named, with a token of its own. Keywords and errors as in
        feltwire.follow()."""
        self._require_open()
        from .follower import follow
        scene = scene or self.scenes[0]
        return follow(self.address, scene, fingerprint_file=self.fingerprint_file, token_file=self._token("follower", scene), **options)

    def _token(self, role: str, scene: str) -> str:
        """The path of a token of this role, which is made when it is first asked for."""
        if scene != "*" and scene not in self.scenes:
            raise ValueError(f"the server has no scene {scene}; its scenes are: {', '.join(self.scenes)}")
        state = pathlib.Path(self.token_file).parent
        token = state / (f"{role}.token" if scene == "*" else f"{role}-{self.scenes.index(scene)}.token")
        if not token.exists():
            done = subprocess.run([program("feltwire-server"), "token", "add", "--state", str(state), "--client", "python", "--scene", scene,
                                   "--role", role, "--expires", "never", "--out", str(token)], capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise Error(f"no token of the role {role}: {done.stderr.strip()}")
        return str(token)

    def _require_open(self) -> None:
        if not self._finalizer.alive:
            raise ValueError("the server is closed")

    def close(self) -> None:
        """Ends the server. May be called again."""
        self._finalizer()
        if self._drain is not None:
            self._drain.join()
        if self.process.stdout is not None:
            self.process.stdout.close()
        self._folder.cleanup()

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
