"""Checks of a server: the shapes of a scene, rebuilt from the wire alone and compared with the scene file."""
import json
import math
import re

from checks import check, expect
from checks_control import refused
from schema import CONTROL
from server_process import SOURCE

GROUPS = CONTROL.enums["ShapeGroup"].values
HERE = SOURCE / "tests/conformance"
# The numbers of each primitive as they travel, from those in a scene file.
LENGTHS = {
    "plane": lambda _: [], "sphere": lambda one: [one["radius"]], "box": lambda one: [side / 2 for side in one["size"]],
    "capsule": lambda one: [one["radius"], one["length"] / 2], "cylinder": lambda one: [one["radius"], one["length"] / 2],
    "cone": lambda one: [one["radius"], one["length"] / 2], "torus": lambda one: [one["major_radius"], one["minor_radius"]],
    "line": lambda one: [one["length"] / 2] if "length" in one else [], "point": lambda _: [], "curve": lambda _: [], "mesh": lambda _: [],
    "grid": lambda _: []}
ACTIONS = ("attract", "keep_out", "magnet", "viscosity", "constant")


def scene_file(name):
    """The scene of a file with comments."""
    return json.loads(re.sub(r"(?m)^\s*//.*$", "", (HERE / name).read_text(encoding="utf-8")))


def described(control, scene, group, version=None):
    """All descriptions of a group."""
    shapes = []
    while True:
        answer = control.ask("DescribeShapes", scene=scene, group=GROUPS[group], **{"from": len(shapes)})
        expect(version in (None, answer.version), f"version {answer.version} after {version}")
        expect(len(answer.shapes) <= 100, f"{len(answer.shapes)} shapes in one answer")
        shapes += answer.shapes
        if len(shapes) >= answer.count:
            expect(len(shapes) == answer.count, f"{len(shapes)} of {answer.count} {group}")
            return answer, shapes
        expect(answer.shapes, f"an answer brings none of {answer.count - len(shapes)} missing {group}")


def fetched(control, scene, version, group, index):
    """(vertices, triangles) of a shape with parts."""
    vertices, triangles = [], []
    while True:
        part = control.ask("GetShape", scene=scene, version=version, group=GROUPS[group], index=index, vertices=len(vertices),
                           triangles=len(triangles))
        expect(len(part.vertices) <= 1200 and len(part.triangles) <= 1200, f"{len(part.vertices)} and {len(part.triangles)} in a part")
        vertices += [(v.x, v.y, v.z) for v in part.vertices]
        triangles += [(t.a, t.b, t.c) for t in part.triangles]
        if (len(vertices), len(triangles)) == (part.all_vertices, part.all_triangles):
            return vertices, triangles
        expect(part.vertices or part.triangles, "a part brings nothing")


def near(one, other, tolerance=1e-12):
    return len(one) == len(other) and all(abs(a - b) <= tolerance for a, b in zip(one, other))


def compare(shape, wanted, index):
    """A description with an object or a guide of the scene file."""
    kind = next((name for name in LENGTHS if name in wanted), "everywhere")
    expect((shape.name, shape.shape) == (wanted["name"], kind), f"{wanted['name']} is told as {shape.name}, {shape.shape}")
    lengths = LENGTHS[kind](wanted[kind]) if kind in LENGTHS else []
    expect(near(shape.lengths, lengths), f"{shape.name}: lengths {shape.lengths}, not {lengths}")
    expect(shape.material == wanted.get("material"), f"{shape.name}: material {shape.material}")
    expect(shape.from_inside == (wanted.get("felt_from") == "inside"), f"{shape.name}: from_inside {shape.from_inside}")
    expect(shape.moves == ("body" in wanted), f"{shape.name}: moves {shape.moves}")
    expect(shape.action == next((name for name in ACTIONS if name in wanted), None), f"{shape.name}: action {shape.action}")
    expect(shape.parts == (kind in ("mesh", "grid", "curve")), f"{shape.name}: parts {shape.parts}")
    if "body" not in wanted:
        position, turn = wanted.get("position", [0, 0, 0]), wanted.get("orientation", [1, 0, 0, 0])
        expect(near(shape.position.values(), position) and near(shape.orientation.values(), turn), f"{shape.name}: pose {shape}")
    return kind


@check("S-426", "A client that draws what its hand feels asks for three lists (`DescribeShapes`), and for the parts of the shapes that have some "
       "(`GetShape`).", "shapes")
def rebuilt(server):
    scene, control, kinds = scene_file("shapes.json"), server.control("observer"), {}
    answer, objects = described(control, "shapes", "objects")
    expect(answer.scene == scene["description"], f"the scene is described as {answer.scene}")
    # Static objects come first, each in the order of the file.
    wanted = [one for one in scene["objects"] if "body" not in one] + [one for one in scene["objects"] if "body" in one]
    expect(len(objects) == len(wanted), f"{len(objects)} objects of {len(wanted)}")
    for index, (shape, one) in enumerate(zip(objects, wanted)):
        kinds[compare(shape, one, index)] = index
    lid = objects[-1]
    expect(near(lid.position.values(), (0, 0.4, 0.2)), f"the lid is at {lid.position}")
    _, guides = described(control, "shapes", "guides", answer.version)
    for index, (shape, one) in enumerate(zip(guides, scene["guides"])):
        kinds.setdefault(compare(shape, one, index), index)
    expect(set(LENGTHS) | {"everywhere"} == set(kinds), f"no {set(LENGTHS) - set(kinds)} in the scene")

    vertices, triangles = fetched(control, "shapes", answer.version, "objects", kinds["mesh"])
    file = [line.split() for line in (HERE / "pyramid.obj").read_text().splitlines()]
    corners = [tuple(float(part) / 100 for part in words[1:]) for words in file if words[0] == "v"]
    faces = [tuple(corners[int(part) - 1] for part in words[1:]) for words in file if words[0] == "f"]

    def turned(face):  # begins with the least corner
        face = [tuple(round(part, 9) + 0.0 for part in corner) for corner in face]
        first = face.index(min(face))
        return tuple(face[first:] + face[:first])
    expect({turned(face) for face in faces} == {turned([vertices[corner] for corner in triangle]) for triangle in triangles},
           "the mesh has other triangles than its file")
    vertices, triangles = fetched(control, "shapes", answer.version, "objects", kinds["grid"])
    farthest = max(abs(math.dist(vertex, (0, 0, 0)) - 0.03) for vertex in vertices)
    expect(farthest < 0.002, f"the surface of the grid is {farthest} m off its sphere")
    expect(len(triangles) > 1000 and max(max(triangle) for triangle in triangles) < len(vertices), f"{len(triangles)} triangles")
    curve, index = next(one for one in scene["guides"] if "curve" in one), [one.shape for one in guides].index("curve")
    vertices, triangles = fetched(control, "shapes", answer.version, "guides", index)
    expect([list(map(float, point)) for point in curve["curve"]["points"]] == [list(vertex) for vertex in vertices] and not triangles, f"{vertices}")
    expect(guides[index].closed, "the curve is not closed")

    _, tools = described(control, "shapes", "tools")
    expect([(one.name, one.shape, list(one.lengths)) for one in tools] == [("tip", "point", []), ("marble", "sphere", [0.004])], f"{tools}")
    answer, tools = described(control, "mallet", "tools")
    body = next(place for place, one in enumerate(tools) if one.shape == "points")
    points, triangles = fetched(control, "mallet", answer.version, "tools", body)
    expect(len(points) >= 100 and not triangles, f"{len(points)} points of a tool with a body")
    control.close()
    return f"{len(objects)} objects, {len(guides)} guides and 2 tools are what the scene file says; {len(points)} points of a tool with a body"


@check("S-427", "`bad_scene` if the scene has another version by now; `bad_parameters` for a shape without parts.", "shapes")
def refusals(server):
    control = server.control("observer")
    version = described(control, "shapes", "objects")[0].version
    for group, index in (("objects", 0), ("objects", 99999), ("guides", 0), ("tools", 0), ("tools", 2)):
        refused("bad_parameters", control, "GetShape", scene="shapes", version=version, group=GROUPS[group], index=index)
    refused("bad_scene", control, "GetShape", scene="shapes", version=version + 1, index=7)
    refused("unknown_scene", control, "DescribeShapes", scene="no such scene")
    refused("unknown_scene", control, "GetShape", scene="no such scene", version=version, index=7)
    control.close()
    narrow = server.control("narrow")
    refused("unknown_scene", narrow, "DescribeShapes", scene="shapes")
    narrow.close()
    follower = server.control("follower")
    refused("forbidden", follower, "DescribeShapes", scene="seat")
    follower.close()
    return "parts of a plane, a point and of what there is not, of another version, and of scenes that a token does not open are refused"
