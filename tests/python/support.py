"""For the tests of the Python package. FELTWIRE_LIBRARY and FELTWIRE_PROGRAMS name what was built."""
import os
import pathlib
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = SOURCE / "client/python"
sys.path.insert(0, str(PACKAGE))

LONGEST = 60.0  # [s]
# Nobody holds these hands. A busy machine may let a thread wait, which must not end a run.
PATIENT = {"let_go_after": 1, "flight_recorder": "off"}

try:
    import numpy
except ImportError:
    numpy = None

# At the beginning of a program: NumPy and matplotlib are not installed.
WITHOUT_NUMPY = "import sys\nsys.modules['numpy'] = sys.modules['matplotlib'] = None\n"

# At the beginning of a program that others wrote: its hands are as patient.
PATIENTLY = f"""
import feltwire.hand
def _join(server, scene, _join=feltwire.hand.join, **options):
    if options.get("device") == "caller":
        options.update(stale_after=0.2, hold_time=1)
    return _join(server, scene, **{{**{PATIENT}, **options}})
feltwire.hand.join = _join
import feltwire.world
class _World(feltwire.world.World):
    def __init__(self, **options):
        super().__init__(**{{**{PATIENT}, "hold_time": 1, **options}})
feltwire.world.World = _World
"""


def without_schedule(messages):
    """The messages but for the one that this machine permits no real-time scheduling."""
    return [message for message in messages if "real-time scheduling" not in message]


def eventually(what, condition):
    """Waits until the condition holds, and returns its value."""
    end = time.monotonic() + LONGEST
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.005)
    raise AssertionError(f"it did not happen within {LONGEST} s: {what}")


def run_python(code, *arguments, folder=SOURCE, **environment):
    """What a program of this text prints. It finds the package."""
    done = subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, cwd=folder, check=False,
                          env={**os.environ, "PYTHONPATH": str(PACKAGE), "MPLBACKEND": "agg", **environment})
    if done.returncode:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout
