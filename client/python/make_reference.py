#!/usr/bin/env python3
"""Writes docs/python_reference.md from the docstrings of the package: make_reference.py [--check]

The sources are read, and not imported, so neither the library nor another package is needed. A public name without a docstring is an error. With
--check nothing is written; the exit status is 1 if the page is not what the docstrings say.
"""
import ast
import inspect
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs/python_reference.md"

# (title, module, names). Without names: all public ones of the module, which a program reaches as feltwire.MODULE.
PARTS = [
    ("A server", "served", ["serve", "play", "Server"]),
    ("A hand", "hand", ["join", "Hand"]),
    ("A recording of a hand", "recorder", ["Recorder"]),
    ("Your own physics", "world", ["World", "Patch"]),
    ("A robot that follows", "follower", ["follow", "Follower"]),
    ("An observer", "observer", ["observe", "Observer"]),
    ("An admin", "admins", ["admin", "Admin"]),
    ("Scenes", "scenes", ["Scene"]),
    ("Recordings", "recordings", ["read", "Recording", "DamageWarning"]),
    ("Tables and plots", "tables", ["Table"]),
    ("", "plots", ["plot"]),
    ("Errors", "errors", ["Error", "Refused", "ServerError", "FileError", "SceneError"]),
    ("asyncio", "aio", None),
    ("The laboratory", "lab", None),
    ("LeRobot", "lerobot", None),
    ("Isaac Lab", "isaac", None),
    ("Gymnasium", "gym", None),
]
INTERNAL = {"renew_locks"}  # methods for other modules of the package
MADE = {"World", "Scene", "FeltDevice", "FeltEnv"}  # classes that a program makes itself; functions return the others


def fail(module, name):
    sys.exit(f"client/python/feltwire/{module}.py: {name} has no docstring; say what it does, with units and errors")


def constants(tree):
    """{name: value} of the module's private constants, which stand as defaults."""
    return {node.targets[0].id: node.value for node in tree.body
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and isinstance(node.value, (ast.Constant, ast.Tuple))}


def signature(function, known):
    """The arguments with their defaults. The docstring says what they are."""
    given = function.args
    for argument in (*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg):
        if argument is not None:
            argument.annotation = None
    given.args = [argument for argument in given.args if argument.arg not in ("self", "cls")]
    shown = [number for number, argument in enumerate(given.kwonlyargs) if not argument.arg.startswith("_")]
    given.kwonlyargs, given.kw_defaults = [given.kwonlyargs[i] for i in shown], [given.kw_defaults[i] for i in shown]
    for defaults in (given.defaults, given.kw_defaults):
        defaults[:] = [known.get(one.id, one) if isinstance(one, ast.Name) else one for one in defaults]
    return ast.unparse(given)


def described(node, module, name):
    """The docstring. An example in it keeps its indentation, also where no other line is below the first."""
    text = ast.get_docstring(node, clean=False)
    if not text:
        fail(module, name)
    indentation = 0 if isinstance(node, ast.Module) else node.col_offset + 4
    first, *others = text.rstrip().splitlines()
    return "\n".join([first, *(line[indentation:] if not line[:indentation].strip() else line.strip() for line in others)])


def named(nodes, kind):
    return [node for node in nodes if isinstance(node, kind) and not node.name.startswith("_")]


def attributes(body):
    """(name, documentation) of the fields of a class that have a text below them."""
    for before, after in zip(body, body[1:]):
        if isinstance(before, (ast.AnnAssign, ast.Assign)) and isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            target = before.target if isinstance(before, ast.AnnAssign) else before.targets[0]
            yield (target.attr if isinstance(target, ast.Attribute) else target.id), inspect.cleandoc(after.value.value)


def function_lines(node, module, known):
    kind = "async " if isinstance(node, ast.AsyncFunctionDef) else ""
    is_property = any(isinstance(one, ast.Name) and one.id == "property" for one in node.decorator_list)
    arguments = "" if is_property else f"({signature(node, known)})"
    return [f"**`{kind}{node.name}{arguments}`**", "", described(node, module, node.name), ""]


def methods(node, classes):
    """Its own, and those of its private bases in the same module, nearest first."""
    found = {one.name: one for one in named(node.body, (ast.FunctionDef, ast.AsyncFunctionDef)) if one.name not in INTERNAL}
    for base in node.bases:
        if isinstance(base, ast.Name) and base.id in classes and base.id.startswith("_"):
            found = {**found, **{name: one for name, one in methods(classes[base.id], classes).items() if name not in found}}
    return found


def class_lines(node, module, prefix, tree, known):
    classes = {one.name: one for one in tree.body if isinstance(one, ast.ClassDef)}
    makers = [one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"]
    out = [f"`{prefix}{node.name}({signature(makers[0], known)})`", ""] if node.name in MADE else []
    out += [described(node, module, node.name), ""]
    out += [f"It has all that {base.id} has." for base in node.bases if isinstance(base, ast.Name) and base.id in ("Hand", "Result")]
    out += [""] if out[-1] else []
    fields = [*attributes(node.body), *(field for maker in makers for field in attributes(maker.body))]
    if fields:
        out += ["| field | |", "|---|---|", *("| `{}` | {} |".format(name, " ".join(text.split()).replace("|", "\\|")) for name, text in fields), ""]
    for one in methods(node, classes).values():
        # A method of another package's interface is described there.
        if ast.get_docstring(one) or not prefix:
            out += function_lines(one, module, known)
    return out


def page():
    listed = {name for _, _, names in PARTS for name in names or []} | {module for _, module, names in PARTS if names is None}
    package = ast.parse((HERE / "feltwire/__init__.py").read_text(encoding="utf-8"))
    public = next(ast.literal_eval(node.value) for node in package.body
                  if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__")
    if set(public) != listed:
        sys.exit(f"PARTS of make_reference.py and feltwire.__all__ differ in {sorted(set(public) ^ listed)}")
    out = ["# The Python package, name by name", "", "<!-- Written by client/python/make_reference.py from the docstrings. Change these. -->", "",
           "The tutorial is [python.md](python.md). The fields of ticks, states, hands, bodies and targets are those of the structs in",
           "[c_reference.md](c_reference.md): `feltwire.abi.Tick` is `fw_tick`. Units are SI. All is in the module `feltwire`.", ""]
    for title, module, names in PARTS:
        tree = ast.parse((HERE / f"feltwire/{module}.py").read_text(encoding="utf-8"))
        known = constants(tree)
        kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
        found = {node.name: node for node in named(tree.body, kinds)}
        # Classes of another package's kind are made when they are asked for.
        for maker in tree.body:
            found.update((node.name, node) for node in (named(maker.body, ast.ClassDef) if isinstance(maker, ast.FunctionDef) else []))
        prefix = "" if names else f"{module}."
        out += [f"## {title}", ""] if title else []
        if names is None:
            out += [described(tree, module, "the module"), ""]
        for name in names or found:
            if isinstance(found[name], ast.ClassDef):
                out += [f"### {prefix}{name}", "", *class_lines(found[name], module, prefix, tree, known)]
            else:
                out += [f"### {prefix}{name}()", "", f"`{prefix}{name}({signature(found[name], known)})`", "", described(found[name], module, name), ""]
    return "\n".join(out).rstrip() + "\n"


if __name__ == "__main__":
    stale = not PAGE.exists() or PAGE.read_text(encoding="utf-8") != page()
    if sys.argv[1:] == ["--check"]:
        sys.exit("run client/python/make_reference.py: docs/python_reference.md is not what the docstrings say" if stale else 0)
    PAGE.write_text(page(), encoding="utf-8")
