#!/usr/bin/env python3
"""A thin client has the drivers that its build was asked for, and no other. It configures such builds and builds none.

usage: check_drivers.py SOURCE_FOLDER COMPILER
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ASKED = (["haply"], ["novint", "open_haptics"])


def run(*command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def rooms_of_drivers(source):
    """The rooms below client/drivers that an option leaves out."""
    makers = re.search(r"foreach\(maker ([^)]*)\)", (source / "cmake/drivers.cmake").read_text(encoding="utf-8"))[1].split()
    missing = [maker for maker in makers if not (source / "client/drivers" / maker).is_dir()]
    if missing:
        sys.exit(f"client/drivers has no {missing}")
    return makers


def built(folder, makers):
    """The makers of whom the program and the installed library have an object."""
    objects = run("ninja", "-C", folder, "-t", "inputs", "feltwire-client", "libfeltwire_client.a")
    if "drivers/plugin/" not in objects:
        sys.exit(f"the objects of a client are not as this check expects them:\n{objects}")
    return sorted(maker for maker in makers if f"drivers/{maker}/" in objects)


def main():
    source, compiler = Path(sys.argv[1]).resolve(), sys.argv[2]
    makers = rooms_of_drivers(source)
    for asked in ([], *ASKED):
        with tempfile.TemporaryDirectory(prefix="feltwire-drivers-") as folder:
            told = run("cmake", "-S", source, "-B", folder, "-G", "Ninja", "-DFELTWIRE_COMPONENTS=client", f"-DCMAKE_CXX_COMPILER={compiler}",
                       *(f"-DFELTWIRE_DRIVER_{maker.upper()}=ON" for maker in asked))
            has = built(folder, makers)
            if has != sorted(asked):
                sys.exit(f"a thin client that is asked for {asked} has the drivers of {has}")
            for maker in makers:
                if (f"-DFELTWIRE_DRIVER_{maker.upper()}=ON" in told) == (maker in asked):
                    sys.exit(f"cmake says the wrong thing of {maker}:\n{told}")
            print(f"asked for {asked or 'none'}: that is what the client has")


main()
