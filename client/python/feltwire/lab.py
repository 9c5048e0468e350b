"""The verbs of feltwire-lab as functions: feltwire.lab.touch(...), feltwire.lab.run("contact-frame-options", ...)."""
from __future__ import annotations

import functools
import json
import os
import pathlib
import re
import subprocess
import tempfile
from typing import Any, Callable, Dict, List, Optional, Union

from .errors import Error, FileError
from .library import program
from .options import words
from .scenes import Scene
from .tables import Table, from_csv, to_csv, vectors


class Result:
    """What a verb of feltwire-lab said and wrote.

    text: its output. said: its warnings and errors. status: its exit status. table: the output as a Table, if it is CSV. json: the output
    parsed, if it is JSON. tables and documents: the CSV and JSON files that it wrote, by their name without .csv and .json.
    """

    def __init__(self, verb: str, done: "subprocess.CompletedProcess[str]", folder: Optional[pathlib.Path]):
        self.text, self.said, self.status = done.stdout, done.stderr, done.returncode
        self.table = _table(self.text, "the output", verb)
        self.json = _json(self.text)
        self.tables: Dict[str, Table] = {}
        self.documents: Dict[str, Any] = {}
        for path in sorted(folder.iterdir()) if folder is not None and folder.is_dir() else []:
            if path.suffix == ".csv" and (table := _table(path.read_text(encoding="utf-8"), str(path), path.stem)) is not None:
                self.tables[path.stem] = table
            elif path.suffix == ".json":
                self.documents[path.stem] = _json(path.read_text(encoding="utf-8"))

    def __repr__(self) -> str:
        return self.text


def _table(text: str, name: str, topic: str) -> Optional[Table]:
    if not re.match(r"[^\s,{\[]+(,[^\s,]+)*\n", text) or "," not in text.split("\n", 1)[0]:
        return None
    try:
        columns = vectors(from_csv(text.splitlines(keepends=True), name))
    except FileError:
        return None  # other text that has commas
    return Table(topic, columns, columns.get("time"), columns.get("log_time_ns"))


def _json(text: str) -> Any:
    if not text.lstrip().startswith(("{", "[")):
        return None
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return None


def _help(*verb: str) -> str:
    return subprocess.run([program("feltwire-lab"), *verb, "--help"], capture_output=True, text=True, check=True).stdout


@functools.lru_cache(maxsize=None)
def _option_of_folder(verb: str) -> Optional[str]:
    """The option of a verb that names the folder of its results."""
    found = re.search(r"--out\b", _help(verb))
    return "out" if found else None


@functools.lru_cache(maxsize=None)
def _verbs() -> Dict[str, str]:
    lines = _help().split("Subcommands:\n", 1)[1].splitlines()
    return {found[1]: found[2] for found in (re.match(r"  ([a-z][\w-]*) +(\S.*)", line) for line in lines) if found}


def verbs() -> Dict[str, str]:
    """The verbs of feltwire-lab, each with a line of help."""
    return dict(_verbs())


def run(verb: str, *arguments: Union[str, "os.PathLike[str]"], table: Any = None, check: bool = True, timeout: Optional[float] = None,
        **options: Any) -> Result:
    """Runs a verb of feltwire-lab until it ends, and returns what it said and wrote.

    arguments: its words, as files. options: its options with _ for -: damping=0.5, account=True; a list becomes numbers with commas; a Scene
    may be given for scene. table: rows for its input: a dict of columns, a NumPy array with fields, or a list of dicts; touch and bound read
    them. Files that it writes into a folder of results (out) are parsed; without `out` they are in a folder that is removed afterwards.
    export writes nothing but files: csv=True gives its tables. timeout [s].

    Raises Error with its words if its exit status is not 0; with check=False the status is in the result. Raises subprocess.TimeoutExpired.
    """
    with tempfile.TemporaryDirectory(prefix="feltwire-") as name:
        scene, folder = options.get("scene"), None
        if isinstance(scene, Scene):
            options["scene"] = scene.place(name)
        results = "csv" if verb == "export" else _option_of_folder(verb)
        if results is not None and options.get(results, True) is True and "npz" not in options:
            options[results] = pathlib.Path(name) / "results"
        if results is not None and options.get(results) is not None:
            folder = pathlib.Path(options[results])
        command = [program("feltwire-lab"), verb, *[os.fspath(one) for one in arguments], *words(options, repeat=verb == "link")]
        done = subprocess.run(command, input=None if table is None else to_csv(table), stdin=subprocess.DEVNULL if table is None else None,
                              capture_output=True, text=True, check=False, timeout=timeout)
        result = Result(verb, done, folder)
    if check and done.returncode != 0:
        raise Error((done.stderr.strip() or done.stdout.strip()).replace(name + os.sep, "") or f"feltwire-lab {verb} ended with {done.returncode}")
    return result


def __getattr__(name: str) -> Callable[..., Result]:
    verb = name.replace("_", "-")
    if name.startswith("_") or verb not in _verbs():
        raise AttributeError(f"feltwire-lab has no verb {verb}; feltwire.lab.verbs() lists them")
    return functools.partial(run, verb)


def __dir__() -> List[str]:
    return ["Result", "run", "verbs", *(verb.replace("-", "_") for verb in _verbs())]
