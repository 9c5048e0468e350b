#!/usr/bin/env python3
"""The binary interface of libfeltwire.so.0, as libfeltwire.abi: abi_dump.py [--check | --accept]

Compiles a library that has the functions of api_table.py with nothing in them, so that the dump has what feltwire.h promises and no trace of
compiler options or of the C++ behind it. abidw writes it, and abidiff compares it with the committed dump. New functions, and new fields at
the end of a struct, are compatible; all else is not. Without an option a dump with compatible changes is written, and one with
other changes is refused. --check writes nothing: the exit status is 1 if the dump is not what the table says. --accept writes it in any case.
--check also compares each struct of Feltwire.cs and of the Python package with the compiler's. Needs abigail-tools and a C compiler.
"""
import ctypes
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import api_table as api
from make_bindings import c_type, class_name

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "python"))
from feltwire import abi as python_abi  # noqa: E402

DUMP = HERE / "libfeltwire.abi"
# A program says how much of a struct it knows, so a struct may grow.
GROWN = "[suppress_type]\n  type_kind = struct\n  has_data_member_inserted_at = end\n"
CHANGED = 4 | 8  # of abidiff's exit status: the interface differs


def every_function():
    """C: the functions of the table, and the numbers of the results as an enum that the dump sees."""
    out = ['#include "feltwire.h"', "enum fw_results {"]
    out += [f"  fw_result_{name} = FW_{name}," for name, _, _ in api.RESULTS]
    out.append("};\nFW_EXPORT enum fw_results fw_results(void) { return (enum fw_results)0; }")
    for result, name, arguments, _, _ in api.FUNCTIONS:
        words = ", ".join(f"{c_type(kind)} {argument}" for kind, argument in arguments) or "void"
        out.append(f"{c_type(result)} fw_{name}({words}) {{ {'' if result == 'void' else 'return 0;'} }}")
    return "\n".join(out) + "\n"


def dump(folder):
    """The dump of the table's interface, in this folder."""
    source, library, made = folder / "functions.c", folder / "libfeltwire.so.0", folder / "libfeltwire.abi"
    source.write_text(every_function(), encoding="utf-8")
    subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-g", "-O0", "-shared", "-fPIC", "-fvisibility=hidden", f"-I{HERE}",
                    "-Wl,-soname,libfeltwire.so.0", "-o", library, source], check=True)
    subprocess.run(["abidw", "--no-show-locs", "--no-corpus-path", "--no-comp-dir-path", "--out-file", made, library], check=True)
    return made


def compared(made, folder, *options):
    """What abidiff says of the committed dump and this one; empty: they are the same."""
    suppressed = folder / "grown.ini"
    suppressed.write_text(GROWN, encoding="utf-8")
    done = subprocess.run(["abidiff", *options, *(["--suppressions", suppressed] if options else []), DUMP, made], capture_output=True,
                          text=True, check=False)
    if done.returncode & ~CHANGED:
        sys.exit(f"abidiff failed: {done.stdout}{done.stderr}")
    return done.stdout if done.returncode else ""


def described(element, by_id):
    """A type in words: "f64[3]" of the table becomes "double[3]"."""
    of = by_id.get(element.get("type-id"))
    if element.tag == "pointer-type-def":
        return f"pointer to {described(of, by_id)}"
    if element.tag == "qualified-type-def":
        return f"const {described(of, by_id)}"
    if element.tag == "array-type-def":
        return described(of, by_id) + "".join(f"[{part.get('length')}]" for part in element.findall("subrange"))
    return element.get("name")


def structs(path):
    """{name of a struct: {field: (offset, type)}} of a dump."""
    root = xml.etree.ElementTree.parse(path).getroot()
    by_id = {element.get("id"): element for element in root.iter() if element.get("id")}
    return {struct.get("name"): {member.find("var-decl").get("name"): (member.get("layout-offset-in-bits"),
                                                                    described(by_id[member.find("var-decl").get("type-id")], by_id))
                                 for member in struct.findall("data-member")}
            for struct in root.iter("class-decl") if struct.get("is-declaration-only") != "yes"}


def changed_fields(made):
    """The fields of the committed dump that are not as they were. The suppression of grown structs hides a changed type from abidiff."""
    now = structs(made)
    return "".join(f"{struct}.{field} was {old[1]} at bit {old[0]}, and is {' at bit '.join(reversed(new)) if new else 'gone'}\n"
                   for struct, fields in structs(DUMP).items() for field, old in fields.items()
                   if (new := now.get(struct, {}).get(field)) != old)


WORDS = {"uint": "uint32_t", "ulong": "uint64_t", "double": "double"}  # of C#; an IntPtr is a pointer
SIZES = {"uint32_t": 4, "uint64_t": 8, "double": 8, "pointer": 8}


def members(path):
    """{name of a struct: ({field: (offset [bytes], type of an element, number of elements)}, size [bytes])} of a dump, as a compiler laid it out."""
    sizes = {struct.get("name"): int(struct.get("size-in-bits")) // 8 for struct in xml.etree.ElementTree.parse(path).getroot().iter("class-decl")
             if struct.get("is-declaration-only") != "yes"}
    found = {}
    for struct, fields in structs(path).items():
        parts = {field: (int(offset) // 8, *re.fullmatch(r"(.*?)(?:\[(\d+)\])?", kind).groups()) for field, (offset, kind) in fields.items()}
        found[struct] = {field: (offset, "pointer" if kind.startswith("pointer") else kind, int(count or 1))
                         for field, (offset, kind, count) in parts.items()}, sizes[struct]
    return found


def csharp():
    """{name of a struct: ({field: (offset, type)}, size)} of Feltwire.cs, whose arrays are a field for each element."""
    text = (HERE / "Feltwire.cs").read_text(encoding="utf-8")
    return {name: ({field: (int(offset), WORDS.get(kind, "pointer" if kind == "IntPtr" else kind))
                    for offset, kind, field in re.findall(r"\[FieldOffset\((\d+)\)\] public (\w+) (\w+);", body)}, int(size))
            for size, name, body in re.findall(r"\[StructLayout\(LayoutKind\.Explicit, Size = (\d+)\)\]\s+public struct (\w+)\s*\{(.*?)\n        \}",
                                               text, re.DOTALL)}


def other_languages(made):
    """Lines for the structs of C# and Python that differ from the compiler's."""
    wrong, sharp = [], csharp()
    for struct, (fields, size) in members(made).items():
        name = class_name(struct.removeprefix("fw_"))
        elements = {field if count == 1 else f"{field}_{i}": (offset + i * SIZES[kind], kind)
                    for field, (offset, kind, count) in fields.items() for i in range(count)}
        if sharp.pop(name, None) != (elements, size):
            wrong.append(f"Feltwire.cs: {name} differs from {struct}")
        one = getattr(python_abi, name)
        placed = {field: (getattr(one, field).offset, getattr(one, field).size) for field, _ in one._fields_}
        if placed != {field: (offset, SIZES[kind] * count) for field, (offset, kind, count) in fields.items()} or ctypes.sizeof(one) != size:
            wrong.append(f"abi.py: {name} differs from {struct}")
        table = getattr(python_abi, f"{struct.removeprefix('fw_').upper()}_DTYPE", None)
        if table and (dict(zip(table["names"], table["offsets"])), table["itemsize"]) != ({field: where for field, (where, *_) in fields.items()}, size):
            wrong.append(f"abi.py: the dtype of {name} differs from {struct}")
    wrong += [f"Feltwire.cs: {name} is no struct of feltwire.h" for name in sharp]
    return "\n".join(wrong)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made = dump(folder)
        if wrong := other_languages(made):
            sys.exit(f"{wrong}\nrun client/c_api/make_bindings.py")
        broken = compared(made, folder, "--no-added-syms") + changed_fields(made) if DUMP.exists() else ""
        if broken and sys.argv[1:] != ["--accept"]:
            sys.exit(f"{broken}\nfeltwire.h has an incompatible change: a program of last year may break with this library. Undo it. If it is "
                     "meant, raise the library's version (SOVERSION in client/CMakeLists.txt, FELTWIRE_0 in feltwire.map, the names of Debian's "
                     "packages), then run client/c_api/abi_dump.py --accept")
        if DUMP.exists() and not broken and not compared(made, folder):
            return
        if sys.argv[1:] == ["--check"]:
            sys.exit("feltwire.h has compatible additions that libfeltwire.abi lacks: run client/c_api/abi_dump.py, and commit it")
        DUMP.write_bytes(made.read_bytes())


if __name__ == "__main__":
    main()
