"""The verbs of feltwire-lab as functions: feltwire.lab.touch(...), feltwire.lab.run("where-to-bound", ...).

compare() and extremes() also judge bounding laws of the program (docs/own_bounding_law.md)."""
from __future__ import annotations

import functools
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import threading
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

from .errors import Error, FileError
from .laws import LawError, LawFailed, LawServer  # noqa: F401
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
        _laws: Optional[LawServer] = None, **options: Any) -> Result:
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
                              capture_output=True, text=True, check=False, timeout=timeout) if _laws is None else _with_laws(command, _laws, timeout)
        result = Result(verb, done, folder)
    if check and done.returncode != 0:
        raise Error((done.stderr.strip() or done.stdout.strip()).replace(name + os.sep, "") or f"feltwire-lab {verb} ended with {done.returncode}")
    return result


def _with_laws(command: List[str], laws: LawServer, timeout: Optional[float]) -> "subprocess.CompletedProcess[str]":
    """Runs a command whose laws this process computes."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as said:
        child = subprocess.Popen([*command, *laws.option], stdin=subprocess.DEVNULL, stdout=out, stderr=said, pass_fds=[laws.child.fileno()])
        ending = threading.Timer(timeout, child.kill) if timeout is not None else None
        try:
            if ending is not None:
                ending.start()
            laws.serve()
            status = child.wait()
        finally:
            late = ending is not None and ending.finished.is_set()
            if ending is not None:
                ending.cancel()
            child.kill()
            child.wait()
        if late and timeout is not None:
            raise subprocess.TimeoutExpired(command, timeout)
        texts = []
        for file in (out, said):
            file.seek(0)
            texts.append(file.read())
    return subprocess.CompletedProcess(command, status, *texts)


class Comparison(Result):
    """What compare() found, for each task and law a row of the table. Printed, it is the laboratory's table.

    table: a Table with the columns task and law (texts), energy_made [J] that the hand got beyond what the device burned (0 is passive),
    stiffness_shown over the commanded one, swing [m] RMS, direction_error [rad] and cost [s] a step. The law "reference" is the surface
    itself: no bound, at 20 kHz. The cost of a law in Python is the laboratory's for asking, without the time in Python.
    """

    def __init__(self, result: Result):
        self.__dict__.update(result.__dict__)
        self.text = self.text.split("\nTables are in ")[0]  # the folder may be gone
        rows, cost = self.tables["compare"], self.tables["compare_cost"]
        columns = {"task": rows["task"], "law": rows["method"]}
        for name, column, unit in (("energy_made", "energy_made_mj", 1e-3), ("stiffness_shown", "displayed", 1.0),
                                   ("swing", "oscillation_um", 1e-6), ("direction_error", "direction_error_deg", math.pi / 180.0)):
            columns[name] = _scaled(rows[column], unit)
        columns["cost"] = _scaled(cost["cost_ns"], 1e-9)
        self.table = Table("compare", columns, None)


def _scaled(column: Any, unit: float) -> Any:
    return unit * column if hasattr(column, "dtype") else [unit * one for one in column]


def compare(*laws: Any, tasks: Optional[Sequence[str]] = None, methods: Optional[Sequence[str]] = None, **options: Any) -> Result:
    """Compares bounding laws of the program with built-in methods on walls, edges, bumps, friction and a tap. Returns a Comparison.

    laws: each a class, an object or a function (docs/own_bounding_law.md). methods: the built-in ones beside them; without it "none" and
    "contact_frame". tasks: of wall, sphere, corner, edge, torus, stick_slip and tap; without it all. options: those of feltwire-lab
    compare, as damping=2 [N s/m], rate=1000 [Hz], delay=5 [ms].

    Without laws it is the verb of feltwire-lab: everything, or in a scene of your own (scene=). Raises LawError for a law that raises an
    error or returns no force, and Error.
    """
    if tasks is not None:
        options["tasks"] = [tasks] if isinstance(tasks, str) else list(tasks)
    if methods is not None:
        options["methods"] = [methods] if isinstance(methods, str) else list(methods)
    if laws and options.get("scene") is not None:
        raise ValueError("compare() takes laws, or a scene for the built-in methods; laws are compared on its own tasks")
    result = _judge("compare", laws, options)
    return Comparison(result) if "compare" in result.tables and "compare_cost" in result.tables else result


def extremes(*laws: Any, methods: Optional[Sequence[str]] = None, check: bool = True, **options: Any) -> Result:
    """Runs bounding laws of the program at the limits of the number range, with hands that take all the energy they can.

    laws, methods: as for compare(); without `methods` the laws alone. hands: how many hands each stress sends. result.tables["extremes"]
    has a row for each stress and law.

    Raises LawFailed with the rows of a law that broke its promise; with check=False the result has status 1. Raises LawError as compare().
    """
    if methods is not None:
        options["methods"] = [methods] if isinstance(methods, str) else list(methods)
    result = _judge("extremes", laws, {**options, "check": False})
    failed = [line for line in result.text.splitlines() if line.startswith("FAILED")]
    if check and result.status != 0:
        if not failed:
            raise Error(result.said.strip() or f"feltwire-lab extremes ended with {result.status}")
        table = result.tables["extremes"]
        rows = [{name: table[name][i] for name in table} for i in range(len(table)) if not table["passed"][i]]
        raise LawFailed("\n".join(failed), rows)
    return result


def _judge(verb: str, laws: Sequence[Any], options: Dict[str, Any]) -> Result:
    if not laws:
        return run(verb, **options)
    server = LawServer(laws)
    try:
        result = run(verb, _laws=server, **{**options, "check": False})
    finally:
        server.close()
    if server.error is not None:
        raise server.error
    if result.status != 0 and (options.get("check", True) or result.said):
        said = (result.said.strip() or result.text.strip()).replace("feltwire-lab: ", "")
        raise (LawError if re.match(r"law \w+: step \d", said) else Error)(said)
    return result


def __getattr__(name: str) -> Callable[..., Result]:
    verb = name.replace("_", "-")
    if name.startswith("_") or verb not in _verbs():
        raise AttributeError(f"feltwire-lab has no verb {verb}; feltwire.lab.verbs() lists them")
    return functools.partial(run, verb)


def __dir__() -> List[str]:
    return ["Comparison", "LawError", "LawFailed", "Result", "run", "verbs", *(verb.replace("-", "_") for verb in _verbs())]
