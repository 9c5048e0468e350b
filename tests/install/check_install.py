#!/usr/bin/env python3
"""Installs feltwire, moves the folder, and builds and runs programs against it: with find_package and with pkg-config. All installed
programs say their version.

The installed my_device (examples/my_device.cpp) then feels a scene of a server that is started for it.

usage: check_install.py SOURCE_FOLDER BUILD_FOLDER COMPILER
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # no files beside the sources
sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("client/python", "tests/support")]
import feltwire  # noqa: E402
from stalled import MOST_STALLS, stalled  # noqa: E402

LET_GO_AFTER = 0.1  # [s]; nobody holds this device, and a busy machine may leave it without ticks for longer than the usual 5 ms


def run(*command, environment=None):
    """Its output; ends the check where it fails. A client that the machine left standing runs again."""
    for _ in range(1 + MOST_STALLS):
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              env=dict(os.environ, **(environment or {})))
        if done.returncode == 0 or not stalled(done.stdout):
            break
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def check_names_no_folder(prefix, folders):
    """What is installed can be moved: no text file names where it was made."""
    for file in sorted(prefix.rglob("*")):
        if file.suffix not in (".cmake", ".pc", ".hpp", ".h"):
            continue
        text = file.read_text(encoding="utf-8")
        for folder in folders:
            if re.search(rf"(?:(?<![\w./-])|(?<=-[IL])){re.escape(str(folder))}\b", text):
                sys.exit(f"{file.relative_to(prefix)} names {folder}")


def check_headers(prefix, compiler):
    """Every header can be included, in one unit and with a stranger's warnings, and needs Eigen alone."""
    headers = sorted(path.relative_to(prefix / "include") for path in (prefix / "include").rglob("*.hpp"))
    if len(headers) < 50:
        sys.exit(f"only {len(headers)} headers were installed")
    unit = "".join(f"#include <{header}>\n" for header in headers)
    flags = run("pkg-config", "--cflags", "eigen3").split()
    done = subprocess.run([compiler, "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-x", "c++", "-",
                           "-isystem", flags[0][2:], f"-I{prefix / 'include'}"], input=unit, text=True, capture_output=True)
    if done.returncode != 0:
        sys.exit(f"the installed headers do not compile:\n{done.stderr}")
    return len(headers)


def feel(program, source, *arguments):
    """What the program says in a scene of a server of its own."""
    with feltwire.serve(source / "scenes/plane.json") as server:
        return run(program, server.address, "plane", *arguments,
                   environment={"FELTWIRE_FINGERPRINT_FILE": server.fingerprint_file, "FELTWIRE_TOKEN_FILE": server.token_file})


def main():
    source, build, compiler = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3]
    os.environ["FELTWIRE_PROGRAMS"] = str(build / "bin")
    with tempfile.TemporaryDirectory(prefix="feltwire-install-") as name:
        folder = Path(name)
        first, prefix = folder / "first", folder / "moved"
        run("cmake", "--install", build, "--prefix", first)
        first.rename(prefix)
        check_names_no_folder(prefix, (source, build, first))
        headers = check_headers(prefix, compiler)

        example = source / "examples/my_device.cpp"
        run("cmake", "-S", source / "tests/install/consumer", "-B", folder / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
            f"-DCMAKE_CXX_COMPILER={compiler}", f"-DEXAMPLES={source / 'examples'}")
        run("cmake", "--build", folder / "build", "--parallel", 2)
        run(folder / "build/bound")
        feel(folder / "build/my_device", source, 1, LET_GO_AFTER)

        # The released one includes the header at its place in version 0.1, and does not know functions that were added since.
        for plugin, known in ((source / "examples/my_plugin.c", []),
                              (source / "tests/released/0.1.0/my_plugin.c", ["-Wno-missing-field-initializers"])):
            run("cc", "-std=c99", "-shared", "-fPIC", "-Wall", "-Wextra", "-Wpedantic", "-Werror", *known, f"-I{prefix / 'include'}",
                plugin, "-o", folder / "my_plugin.so")
        run("cc", "-std=c99", "-shared", "-fPIC", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{prefix / 'include'}",
            source / "examples/my_law.c", "-o", folder / "my_law.so", "-lm")

        library = next(prefix.rglob("libfeltwire.so")).parent
        run("cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{prefix / 'include'}",
            source / "examples/my_hand.c", f"-L{library}", f"-Wl,-rpath,{library}", "-lfeltwire", "-lm", "-o", folder / "my_hand")
        for _ in range(1 + MOST_STALLS):  # a busy machine may leave the hand without a pose for longer than stale_after
            said = feel(folder / "my_hand", source)
            most = max((float(force) for force in re.findall(r"force +(\S+) N", said)), default=0.0)
            if most > 0.2:
                break
        else:
            sys.exit(f"my_hand felt no plane:\n{said}")
        exported = run("nm", "-D", "--defined-only", "--format=posix", library / "libfeltwire.so").splitlines()
        others = [line for line in exported if not line.startswith(("fw_", "FELTWIRE_0"))]
        if others or not any(line.startswith("fw_hand_open") for line in exported):
            sys.exit("libfeltwire.so exports something else than fw_*:\n" + "\n".join(others))

        if not any("FieldOffset" in file.read_text(encoding="utf-8") for file in prefix.rglob("Feltwire.cs")):
            sys.exit("the bindings for C#, Feltwire.cs, were not installed")
        for program in ("server", "client", "view", "follower", "lab", "mjcf"):
            said = run(prefix / f"bin/feltwire-{program}", "--version")
            if not said.startswith(f"feltwire-{program} "):
                sys.exit(f"the installed feltwire-{program} --version says:\n{said}")

        flags = run("pkg-config", "--cflags", "--libs", "feltwire",
                    environment={"PKG_CONFIG_PATH": str(next(prefix.rglob("feltwire.pc")).parent)}).split()
        run(compiler, "-std=c++20", example, *flags, "-o", folder / "my_device")
        feel(folder / "my_device", source, 1, LET_GO_AFTER)
        print(f"{headers} headers; my_device built with find_package and with pkg-config, each felt the plane")


main()
