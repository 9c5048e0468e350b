#!/usr/bin/env python3
"""Runs tests of the package with the library that clang built with sanitizers: with_asan.py BUILD_FOLDER TEST.py ...

Python has no sanitizer, so its runtime is preloaded. What the tests start are the programs of FELTWIRE_PROGRAMS, and
Python programs with FELTWIRE_LIBRARY, without it.
"""
import importlib
import os
import pathlib
import runpy
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent

if "FELTWIRE_PRELOADED" not in os.environ:
    runtime = subprocess.run(["clang++", "-print-file-name=libclang_rt.asan-x86_64.so"], capture_output=True, text=True, check=True).stdout.strip()
    library = pathlib.Path(sys.argv[1]).resolve() / "lib/libfeltwire.so"
    # Python's own memory, and that of its modules, is never freed at the end.
    os.execve(sys.executable, [sys.executable, *sys.argv],
              {**os.environ, "LD_PRELOAD": runtime, "FELTWIRE_PRELOADED": os.environ["FELTWIRE_LIBRARY"], "FELTWIRE_LIBRARY": str(library), "PYTHONMALLOC": "malloc",
               "PYTHONDONTWRITEBYTECODE": "1", "ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "halt_on_error=1"})

sys.path[:0] = [str(HERE), str(HERE.parents[1] / "client/python")]
importlib.import_module("feltwire.library").BLOCKING  # pylint: disable=expression-not-assigned
# Programs that the tests start have no runtime.
del os.environ["LD_PRELOAD"]
os.environ["FELTWIRE_LIBRARY"] = os.environ.pop("FELTWIRE_PRELOADED")
suite = unittest.TestSuite()
for name in sys.argv[2:]:
    contents = runpy.run_path(str(HERE / name))
    for kind in contents.values():
        if isinstance(kind, type) and issubclass(kind, unittest.TestCase):
            suite.addTests(unittest.defaultTestLoader.loadTestsFromTestCase(kind))
sys.exit(not unittest.TextTestRunner().run(suite).wasSuccessful())
