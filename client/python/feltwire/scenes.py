"""Scenes that a program writes: a dict that becomes the JSON of docs/scenes.md."""
from __future__ import annotations

import copy
import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Union

from .errors import SceneError
from .library import program

Vector = Sequence[float]
Path = Union[str, "os.PathLike[str]"]


class Explanation(NamedTuple):
    """What the server says about a scene: its objects and what they cost, and its warnings."""
    text: str
    warnings: List[str]


def turned(axis: Vector, degrees: float) -> List[float]:
    """The quaternion w, x, y, z of a turn about an axis: turned((1, 0, 0), -90). Raises ValueError for an axis of no length."""
    length = math.sqrt(sum(one * one for one in axis))
    if not length > 0.0:
        raise ValueError("the axis has no length")
    half = math.radians(degrees) / 2.0
    return [math.cos(half)] + [math.sin(half) * one / length for one in axis]


def _plain(value: Any) -> Any:
    """For JSON: NumPy's numbers and arrays, and paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} cannot be in a scene")


class Scene:
    """A scene: materials, objects of them, and more. docs/scenes.md has every field and its unit.

        scene = feltwire.Scene("kitchen")
        scene.material("steel", 1500, static_friction=0.2, dynamic_friction=0.15)
        scene.plane("table", material="steel")
        scene.sphere("knob", 0.02, position=(0, 0, 0.02), material="steel")

    data is the dict itself: what has no method here is written into it, scene.data["gravity"] = [0, 0, -9.81]. folder: where files that the
    scene names by a relative path are; save() does not change these paths. Keywords of the methods are the fields of docs/scenes.md: an
    object also takes position [m], orientation (w, x, y, z), felt_from and body. Nothing is checked here, the server does it: check().
    """

    def __init__(self, name: str, *, folder: Path = ".", **fields: Any):
        self.folder: Path = folder
        self.data: Dict[str, Any] = {"name": name, **fields, "materials": [], "objects": []}

    @classmethod
    def load(cls, path: Path) -> "Scene":
        """A scene file, to change it. Its comments are lost. Raises SceneError for a text that is no JSON."""
        path = pathlib.Path(path)
        text = path.read_text(encoding="utf-8")
        try:
            data = json.loads(_without_comments(text))
        except json.JSONDecodeError as error:
            raise SceneError(f"{path}:{error.lineno}: {error.msg}; feltwire-server --explain says more") from None
        if not isinstance(data, dict):
            raise SceneError(f"{path}:1: a scene is a JSON object")
        scene = cls(str(data.get("name", path.stem)), folder=path.parent)
        scene.data = data
        return scene

    @property
    def name(self) -> str:
        """The name that clients join with."""
        return str(self.data["name"])

    def _add(self, kind: str, fields: Dict[str, Any]) -> str:
        self.data.setdefault(kind, []).append(fields)
        return str(fields["name"])

    def material(self, name: str, stiffness: float, **fields: Any) -> str:
        """Adds a material of this stiffness [N/m]. More: damping [N s/m], static_friction, dynamic_friction, viscous_friction [N s/m].
        Returns its name."""
        return self._add("materials", {"name": name, "stiffness": stiffness, **fields})

    def object(self, name: str, shape: Dict[str, Any], *, material: str, **fields: Any) -> str:
        """Adds an object of any shape: scene.object("ball", {"sphere": {"radius": 0.02}}, material="steel"). Returns its name."""
        return self._add("objects", {"name": name, **shape, **fields, "material": material})

    def plane(self, name: str, **fields: Any) -> str:
        """Adds a half space, solid below z = 0 of its own frame."""
        return self.object(name, {"plane": {}}, **fields)

    def sphere(self, name: str, radius: float, **fields: Any) -> str:
        """Adds a ball of this radius [m]."""
        return self.object(name, {"sphere": {"radius": radius}}, **fields)

    def box(self, name: str, size: Vector, **fields: Any) -> str:
        """Adds a box of these full extents [m], centred."""
        return self.object(name, {"box": {"size": size}}, **fields)

    def capsule(self, name: str, radius: float, length: float, **fields: Any) -> str:
        """Adds a capsule along z. length [m]: between the centres of its half spheres."""
        return self.object(name, {"capsule": {"radius": radius, "length": length}}, **fields)

    def cylinder(self, name: str, radius: float, length: float, **fields: Any) -> str:
        """Adds a cylinder along z, centred [m]."""
        return self.object(name, {"cylinder": {"radius": radius, "length": length}}, **fields)

    def cone(self, name: str, radius: float, length: float, **fields: Any) -> str:
        """Adds a cone along z, centred [m], its tip at +length/2."""
        return self.object(name, {"cone": {"radius": radius, "length": length}}, **fields)

    def torus(self, name: str, major_radius: float, minor_radius: float, **fields: Any) -> str:
        """Adds a ring round z. Radius [m] of the circle in the middle of its tube, and of the tube."""
        return self.object(name, {"torus": {"major_radius": major_radius, "minor_radius": minor_radius}}, **fields)

    def mesh(self, name: str, file: Path, *, scale: float, material: str, mesh: Optional[Dict[str, Any]] = None, **fields: Any) -> str:
        """Adds a mesh (.obj, .stl, .ply). scale: [m] of a unit of the file. mesh: more fields of the mesh, {"smooth": True}."""
        return self.object(name, {"mesh": {"file": file, "scale": scale, **(mesh or {})}}, material=material, **fields)

    def body(self, name: str, mass: float, **fields: Any) -> str:
        """Adds a body of this mass [kg] that moves (docs/moving.md): position [m], joint, axis, range, stiffness, damping. An object with
        body=name moves with it. Returns its name."""
        return self._add("bodies", {"name": name, "mass": mass, **fields})

    def guide(self, name: str, place: Dict[str, Any], action: Dict[str, Any], *, max_force: float, **fields: Any) -> str:
        """Adds a force without a surface, of max_force [N] at most: scene.guide("rail", {"line": {"length": 0.1}},
        {"attract": {"stiffness": 250, "range": 0.015}}, max_force=1.5)."""
        return self._add("guides", {"name": name, **place, **fields, **action, "max_force": max_force})

    def tool(self, name: str, **fields: Any) -> str:
        """Adds a tool that hands may choose: scene.tool("finger", sphere={"radius": 0.006}). Without a shape it is a point."""
        return self._add("tools", {"name": name, **fields})

    def text(self) -> str:
        """The JSON. Raises ValueError for a number that is not finite."""
        return _json(self.data)

    def save(self, path: Path) -> pathlib.Path:
        """Writes the file, and returns its path. Files that the scene names are looked for beside it."""
        path = pathlib.Path(path)
        path.write_text(self.text(), encoding="utf-8")
        return path

    def place(self, folder: Path) -> pathlib.Path:
        """Writes the scene into a folder, with whole paths, and returns the file's path."""
        data = copy.deepcopy(self.data)
        _whole_paths(data, pathlib.Path(self.folder).absolute())
        path = pathlib.Path(folder) / (re.sub(r"[^\w.-]+", "_", self.name) + ".json")
        path.write_text(_json(data), encoding="utf-8")
        return path

    def check(self) -> Explanation:
        """Has the server load the scene, and returns what it says: costs and warnings. Raises SceneError with the server's words (file, line
        of text(), field, error, remedy) if it refuses the scene."""
        with tempfile.TemporaryDirectory(prefix="feltwire-") as folder:
            path = self.place(folder)
            done = subprocess.run([program("feltwire-server"), "--explain", str(path)], capture_output=True, text=True, check=False)
            said = done.stderr.replace(folder + os.sep, "")
        lines = [line.replace("feltwire-server: ", "", 1) for line in said.splitlines() if line]
        if done.returncode != 0:
            raise SceneError("\n".join(lines) or f"feltwire-server --explain ended with {done.returncode}")
        return Explanation(done.stdout, lines)


def _json(data: Dict[str, Any]) -> str:
    """One element of a list a line."""
    def dump(value: Any) -> str:
        return json.dumps(value, default=_plain, allow_nan=False, ensure_ascii=False)

    fields = []
    for key, value in data.items():
        if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
            fields.append(f"  {dump(key)}: [\n    " + ",\n    ".join(map(dump, value)) + "\n  ]")
        else:
            fields.append(f"  {dump(key)}: {dump(value)}")
    return "{\n" + ",\n".join(fields) + "\n}\n"


def _whole_paths(value: Any, folder: pathlib.Path) -> None:
    """The relative paths of all files in a scene become whole ones."""
    if isinstance(value, dict):
        if isinstance(value.get("file"), (str, os.PathLike)):
            value["file"] = str(folder / value["file"])
        for one in value.values():
            _whole_paths(one, folder)
    elif isinstance(value, (list, tuple)):
        for one in value:
            _whole_paths(one, folder)


_COMMENT = r"//[^\n]*(?:\n|$)|/\*(?:(?!\*/).)*\*/"
_TOKEN = re.compile(rf'"(?:\\.|[^"\\])*"|{_COMMENT}|[A-Za-z_]\w*(?=\s*:)|,(?=(?:\s|{_COMMENT})*[\]}}])', re.DOTALL)


def _without_comments(text: str) -> str:
    """JSON as json.loads() reads it: scene files may have comments, a comma after the last element and names without quotes."""
    def plain(found: "re.Match[str]") -> str:
        token = found.group()
        if token[0] == '"':
            return token
        if token[0] in "/,":
            return "\n" * token.count("\n")
        return f'"{token}"'

    return _TOKEN.sub(plain, text)
