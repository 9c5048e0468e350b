#!/usr/bin/env python3
"""Writes the bindings of the C interface from api_table.py: make_bindings.py [--check]

feltwire.h (C99 and C++), client/python/feltwire/abi.py (ctypes), Feltwire.cs (C#, blittable structs), docs/c_reference.md, and the symbols of
Debian's package. With --check nothing is written; the exit status is 1 if a file is not what the table says.
"""
import pathlib
import sys
import textwrap

import api_table as api

HERE = pathlib.Path(__file__).resolve().parent
SIZES = {"u32": 4, "i32": 4, "u64": 8, "f64": 8, "text": 8, "texts": 8}
NOTICE = "Written by make_bindings.py from api_table.py. Change the table."


def parts(kind):
    """"f64[3]" -> ("f64", 3); "u32" -> ("u32", 1)"""
    base, _, count = kind.rstrip("]").partition("[")
    return base, int(count or 1)


def fields(struct):
    return [("u32", "struct_size", "[bytes] of this struct, as the program knows it"), ("u32", "reserved", "0"), *struct[2]]


def layout(struct):
    """[(kind, field, offset)] and the size, with natural alignment."""
    at, found = 0, []
    for kind, field, _ in fields(struct):
        base, count = parts(kind)
        at = -(-at // SIZES[base]) * SIZES[base]
        found.append((kind, field, at))
        at += SIZES[base] * count
    return found, -(-at // 8) * 8


def wrapped(text, width, indent):
    return ("\n" + indent).join(textwrap.wrap(text, width))


# C
C = {"u32": "uint32_t", "i32": "int32_t", "u64": "uint64_t", "f64": "double", "text": "const char*", "texts": "const char* const*",
     "void": "void", "u32*": "uint32_t*", "char*": "char*", "text*": "const char**"}


def c_type(kind):
    if kind in C:
        return C[kind]
    constant, name = ("const ", kind[6:]) if kind.startswith("const ") else ("", kind)
    return f"{constant}fw_{name}"


def header():
    out = [f"""/* The C interface of feltwire, version 0. C99 and C++.
 *
 * {NOTICE}
 * docs/c_api.md has a tutorial. Units are SI. Every struct begins with its size: call its fw_..._default() with sizeof, or set
 * struct_size. A function returns a result: below 0 an error, and fw_last_error() has its text. No C++ exception leaves it.
 * Texts are UTF-8 and end in a zero byte. A path, and a word that may be one, has the bytes of the file system.
 * Threads: each function says which thread may call it. "One thread at a time": for each handle. */
#ifndef FELTWIRE_H
#define FELTWIRE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

#if defined(__GNUC__)
#define FW_EXPORT __attribute__((visibility("default")))
#else
#define FW_EXPORT
#endif

/* Results. Their numbers never change. */
enum {{"""]
    for i, (name, number, text) in enumerate(api.RESULTS):
        out.append(f"  FW_{name} = {number}{',' if i + 1 < len(api.RESULTS) else ' '} /* {text} */")
    out.append("};\n")
    for name, text in api.HANDLES:
        out.append(f"typedef struct fw_{name} fw_{name}; /* {text} */")
    out.append("")
    for struct in api.STRUCTS:
        out.append(f"/* {struct[1]} */\ntypedef struct fw_{struct[0]} {{")
        for kind, field, text in fields(struct):
            base, count = parts(kind)
            array = f"[{count}]" if "[" in kind else ""
            out.append(f"  {C[base]} {field}{array}; /* {wrapped(text, 100, '     ')} */")
        out.append(f"}} fw_{struct[0]};\n")
    for result, name, arguments, threads, text in api.FUNCTIONS:
        words = ", ".join(f"{c_type(kind)} {argument}" for kind, argument in arguments) or "void"
        out.append(f"/* {wrapped(text, 120, '   ')}\n   Threads: {threads}. */\nFW_EXPORT {c_type(result)} fw_{name}({words});\n")
    out.append("#ifdef __cplusplus\n}\n#endif\n\n#endif\n")
    return "\n".join(out)


# Python
PY = {"u32": "ctypes.c_uint32", "i32": "ctypes.c_int32", "u64": "ctypes.c_uint64", "f64": "ctypes.c_double", "text": "ctypes.c_char_p",
      "texts": "ctypes.POINTER(ctypes.c_char_p)", "void": "None", "u32*": "ctypes.POINTER(ctypes.c_uint32)", "char*": "ctypes.c_char_p",
      "text*": "ctypes.POINTER(ctypes.c_char_p)"}


NUMPY = {"u32": "u4", "i32": "i4", "u64": "u8", "f64": "f8"}


def class_name(struct):
    return "".join(word.capitalize() for word in struct.split("_"))


def py_type(kind):
    if kind in PY:
        return PY[kind]
    return f"ctypes.POINTER({class_name(kind.replace('const ', '').rstrip('*'))})"


def python():
    out = [f'"""The C interface of feltwire for ctypes. {NOTICE}"""\nimport ctypes\n\nfrom .values import Struct\n']
    for name, number, text in api.RESULTS:
        out.append(f"{name} = {number}  # {text}")
    for struct in api.STRUCTS:
        out.append(f'\n\nclass {class_name(struct[0])}(Struct):\n    """{struct[1]}"""\n    _fields_ = [')
        for kind, field, text in fields(struct):
            base, count = parts(kind)
            array = f" * {count}" if "[" in kind else ""
            out.append(f'        ("{field}", {PY[base]}{array}),  # {text}')
        out.append("    ]")
    for struct in api.STRUCTS:
        found, size = layout(struct)
        if any(parts(kind)[0] in ("text", "texts") for kind, _, _ in found):
            continue
        out.append(f"\n\n# numpy.dtype() takes it.\n{struct[0].upper()}_DTYPE = {{")
        out.append(f'    "names": {[field for _, field, _ in found]},'.replace("'", '"'))
        formats = [NUMPY[parts(kind)[0]] + (f"({parts(kind)[1]},)" if "[" in kind else "") for kind, _, _ in found]
        formats = ", ".join(f'("{f[:2]}", ({f[3:-2]},))' if "(" in f else f'"{f}"' for f in formats)
        out.append(f"    \"formats\": [{formats}],")
        out.append(f'    "offsets": {[offset for _, _, offset in found]},\n    "itemsize": {size},\n}}')
    out.append('\n\ndef declare(library):\n    """Sets the types of all functions of a loaded library, and returns it."""')
    for result, name, arguments, _, _ in api.FUNCTIONS:
        out.append(f"    library.fw_{name}.restype = {PY[result]}")
        out.append(f"    library.fw_{name}.argtypes = [{', '.join(py_type(kind) for kind, _ in arguments)}]")
    out.append("    return library\n")
    return "\n".join(out)


# C#
CS = {"u32": "uint", "i32": "int", "u64": "ulong", "f64": "double", "text": "IntPtr", "texts": "IntPtr", "void": "void",
      "u32*": "out uint", "char*": "byte[]", "text*": "out IntPtr"}


def cs_type(kind):
    return CS[kind] if kind in CS else f"ref {class_name(kind.replace('const ', '').rstrip('*'))}"


def csharp():
    out = [f"// The C interface of feltwire for C#. {NOTICE}\n// All structs are blittable.\nusing System;\n"
           "using System.Runtime.InteropServices;\n\nnamespace Feltwire\n{\n    public static class Native\n    {"]
    for name, number, text in api.RESULTS:
        out.append(f"        public const int {class_name(name.lower())} = {number};  // {text}")
    for struct in api.STRUCTS:
        found, size = layout(struct)
        out.append(f"\n        /// <summary>{struct[1]}</summary>\n        [StructLayout(LayoutKind.Explicit, Size = {size})]\n"
                   f"        public struct {class_name(struct[0])}\n        {{")
        for (kind, field, offset), (_, _, text) in zip(found, fields(struct)):
            base, count = parts(kind)
            for i in range(count):
                name = f"{field}_{i}" if count > 1 else field
                out.append(f"            [FieldOffset({offset + i * SIZES[base]})] public {CS[base]} {name};  // {text}")
        out.append("        }")
    for result, name, arguments, threads, text in api.FUNCTIONS:
        words = ", ".join(f"{cs_type(kind)} {argument}" for kind, argument in arguments)
        out.append(f"\n        /// <summary>{text} Threads: {threads}.</summary>\n        [DllImport(\"feltwire\")]\n"
                   f"        public static extern {CS[result]} fw_{name}({words});")
    out.append("    }\n}\n")
    return "\n".join(out)


def offsets():
    """Lines for a test: static assertions of every offset."""
    out = [f"/* {NOTICE} */\n#include <stddef.h>\n\n#include \"feltwire.h\"\n"]
    for struct in api.STRUCTS:
        found, size = layout(struct)
        for _, field, offset in found:
            out.append(f"typedef char {struct[0]}_{field}[offsetof(fw_{struct[0]}, {field}) == {offset} ? 1 : -1];")
        out.append(f"typedef char size_of_{struct[0]}[sizeof(fw_{struct[0]}) == {size} ? 1 : -1];")
    return "\n".join(out) + "\n"


def result_texts():
    """C++: what each result means."""
    out = ["#pragma once", "// clang-format off", f"// The meaning of each result of the C interface. {NOTICE}", "", "#include <cstdint>", "",
           '#include "client/c_api/feltwire.h"', "", "namespace feltwire {", "",
           "inline const char* result_text(std::int32_t result) noexcept {", "  switch (result) {"]
    for name, _, text in api.RESULTS:
        out += [f"    case FW_{name}:", f'      return "{text}";']
    out += ["    default:", '      return "no result of this library";', "  }", "}", "", "}  // namespace feltwire"]
    return "\n".join(out) + "\n"


def cell(text):
    """A text in a row of a table of Markdown."""
    return text.replace("|", "\\|")


def reference_struct(struct):
    """The table of a struct's fields."""
    lines = [f"### fw_{struct[0]}", "", struct[1], "", "| field | type | |", "|---|---|---|"]
    for kind, field, text in struct[2]:
        base, count = parts(kind)
        lines.append(f"| `{field}` | `{C[base]}{f'[{count}]' if '[' in kind else ''}` | {cell(text)} |")
    return lines + [""]


def reference():
    """docs/c_reference.md: all functions and structs, in parts."""
    structs, begins = {struct[0]: struct for struct in api.STRUCTS}, {name: title for title, name in api.PARTS}
    out = ["# The C interface, function by function", "", f"<!-- {NOTICE} -->", "",
           "The tutorial is [c_api.md](c_api.md). Units are SI, vectors are in the world frame, and a force is the one on the hand. A null text is not given.", "",
           "*Structs.* Each begins with `struct_size` and `reserved`, which the tables leave out. What the program fills in has a `fw_..._default()`, which is "
           "called first with `sizeof`. What the library fills in has its size as an argument of the function instead.", "",
           "*Threads.* \"any thread\": at any time. \"one thread at a time\": of each handle. \"never waits\": it takes no lock, and allocates "
           "nothing unless it fails, so a real-time thread may call it.", "",
           "| result | | |", "|---|---:|---|", *(f"| `FW_{name}` | {number} | {cell(text)} |" for name, number, text in api.RESULTS), "",
           "| handle | |", "|---|---|", *(f"| `fw_{name}` | {cell(text)} |" for name, text in api.HANDLES), ""]
    for result, name, arguments, threads, text in api.FUNCTIONS:
        if name in begins:
            out += [f"## {begins.pop(name)}", ""]
        for kind, _ in arguments:
            struct = structs.pop(kind.removeprefix("const ").rstrip("*"), None)
            if struct is not None:
                out += reference_struct(struct)
        words = ", ".join(f"{c_type(kind)} {argument}" for kind, argument in arguments) or "void"
        out += [f"### fw_{name}()", "", f"`{c_type(result)} fw_{name}({words})`", "", f"{text} *Threads: {threads}.*", ""]
    if structs or begins:
        sys.exit(f"no function takes {list(structs)}; no function is called {list(begins)}")
    return "\n".join(out).rstrip() + "\n"


def symbols():
    """The symbols of Debian's package, each with the version that brought it."""
    names = sorted(["FELTWIRE_0", *(f"fw_{name}" for _, name, *_ in api.FUNCTIONS)])
    lines = [f" {name}@FELTWIRE_0 {api.SINCE.get(name.removeprefix('fw_'), '0.1.0')}" for name in names]
    return "\n".join(["libfeltwire.so.0 libfeltwire0 #MINVER#", "* Build-Depends-Package: libfeltwire-dev", *lines]) + "\n"


for handle, _ in api.HANDLES:
    for words, one, place in ((PY, "ctypes.c_void_p", "ctypes.POINTER(ctypes.c_void_p)"), (CS, "IntPtr", "out IntPtr")):
        words.update({f"{handle}*": one, f"const {handle}*": one, f"{handle}**": place})

FILES = {"feltwire.h": header, "../python/feltwire/abi.py": python, "Feltwire.cs": csharp, "offsets.h": offsets, "result_texts.hpp": result_texts,
         "../../debian/libfeltwire0.symbols": symbols, "../../docs/c_reference.md": reference}

if __name__ == "__main__":
    stale = [name for name, text in FILES.items() if not (HERE / name).exists() or (HERE / name).read_text() != text()]
    if sys.argv[1:] == ["--check"]:
        sys.exit("run client/c_api/make_bindings.py: these files are not what the table says: " + ", ".join(stale) if stale else 0)
    for name in stale:
        (HERE / name).write_text(FILES[name]())
