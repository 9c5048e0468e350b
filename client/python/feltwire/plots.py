"""Pictures of a hand's run, with matplotlib, or with gnuplot where matplotlib is not installed."""
from __future__ import annotations

import math
import os
import shutil
import subprocess
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Union

from .errors import Error
from .recordings import Recording
from .tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_AXES = "xyz"
_BLUE, _ORANGE, _RED, _GREEN = "#1f4e79", "#e8a33d", "#a02020", "#2e7d32"


def plot(run: Any, path: Optional[Union[str, "os.PathLike[str]"]] = None, *, axis: Optional[str] = None) -> "Optional[Figure]":
    """Draws where the hand was [mm], its force [N] and the balance of its energy account [mJ], over time [s]. Returns the Figure.

    run: what Hand.ticks() returned, a Recording of read(), or a Table with the fields time, position and held. A recording also has the
    force that the scene commanded. axis: "x", "y" or "z"; without it that of the largest force. path: the picture is written there, as
    PNG or what its name says; without it matplotlib.pyplot shows it: pyplot.show(), or by itself in a notebook.

    Where matplotlib is not installed and a path is given, gnuplot writes the same as PNG, and None is returned. scripts/plot-recording is
    this function for a shell. Raises Error where neither is installed, and ValueError for a run without ticks or another axis.
    """
    try:
        import numpy
        from matplotlib.figure import Figure
    except ImportError:
        if path is None or shutil.which("gnuplot") is None:
            raise Error("plot() needs matplotlib; install python3-matplotlib, or the Python package matplotlib; or, to write a file, "
                        "gnuplot") from None
        numpy = None
    if axis is not None and axis not in ("x", "y", "z"):
        raise ValueError(f"the axis {axis!r} is not x, y or z")
    series = _series(run)
    if not len(series["time"]):
        raise ValueError("the run has no ticks")
    along = _AXES.index(axis) if axis else largest_axis(series["given"], series.get("commanded"))
    if "balance" in series and not any(math.isfinite(one) for one in series["balance"]):
        del series["balance"]
    if numpy is None:
        _gnuplot(series, along, os.fspath(path or ""))
        return None
    series = {name: numpy.asarray(values, dtype=float) for name, values in series.items()}
    time, commanded, balance, name = series["time"], series.get("commanded"), series.get("balance"), _AXES[along]
    rows = 2 if balance is None else 3
    if path is None:
        from matplotlib import pyplot
        figure = pyplot.figure(figsize=(9, 2.4 * rows), layout="constrained")
    else:
        figure = Figure(figsize=(9, 2.4 * rows), layout="constrained")
    panels = figure.subplots(rows, 1, sharex=True)
    panels[0].plot(time, 1e3 * series["position"][:, along], color=_BLUE)
    panels[0].set_ylabel(f"{name} of the hand [mm]")
    if commanded is not None:
        panels[1].plot(time, commanded[:, along], color=_ORANGE, linewidth=3, label="commanded by the scene")
    panels[1].plot(time, series["given"][:, along], color=_RED, linewidth=1, label="given to the hand")
    panels[1].set_ylabel(f"force along {name} [N]")
    if commanded is not None:
        panels[1].legend(loc="best")
    if balance is not None:
        panels[2].plot(series["balance_time"], 1e3 * balance, color=_GREEN)
        panels[2].set_ylabel("balance of the account [mJ]")
    for panel in panels:
        panel.grid(True, alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    if path is not None:
        figure.savefig(path, dpi=120)
    return figure


def _gnuplot(series: Dict[str, Any], along: int, path: str) -> None:
    """The same by gnuplot. The names go in by the environment: a quote in one is no command to gnuplot."""
    name, panels = _AXES[along], 3 if "balance" in series else 2
    curves = [f"$given with lines lw 1 lc rgb '{_RED}' title 'given to the hand'"]
    data = {"position": [1e3 * row[along] for row in series["position"]], "given": [row[along] for row in series["given"]]}
    if "commanded" in series:
        data["commanded"] = [row[along] for row in series["commanded"]]
        curves.insert(0, f"$commanded with lines lw 3 lc rgb '{_ORANGE}' title 'commanded by the scene'")
    if panels == 3:
        data["balance"] = [1e3 * one for one in series["balance"]]
    script: List[str] = []
    for topic, values in data.items():
        times = series["balance_time"] if topic == "balance" else series["time"]
        script += [f"${topic} << EOD", *(f"{float(time)!r} {float(value)!r}" for time, value in zip(times, values)), "EOD"]
    script += [f"set terminal pngcairo size 900,{280 * panels} font 'sans,11'", r'set output system("printf %s \"$PICTURE\"")',
               f"set multiplot layout {panels},1", "set lmargin 10", "set key outside top center horizontal", "set autoscale xfix", "set grid",
               f"set ylabel '{name} of the hand [mm]'",
               f"plot $position with lines lw 2 lc rgb '{_BLUE}' notitle, 0 lc rgb '#666666' notitle",
               "set xlabel 'time [s]'" if panels == 2 else "", f"set ylabel 'force along {name} [N]'", "plot " + ", ".join(curves)]
    if panels == 3:
        script += ["set xlabel 'time [s]'", "set ylabel 'balance of the account [mJ]'",
                   f"plot $balance with lines lw 1 lc rgb '{_GREEN}' notitle"]
    done = subprocess.run(["gnuplot"], input="\n".join([*script, "unset multiplot", ""]), text=True, capture_output=True, check=False,
                          env={**os.environ, "PICTURE": path, "AXIS": name})
    if done.returncode != 0:
        raise Error(f"gnuplot cannot draw {path}: {done.stderr.strip()}")


def largest_axis(given: Any, commanded: Any = None) -> int:
    """0, 1 or 2: the axis along which the scene or the device pushed hardest; z where nothing pushed."""
    best, most = 2, 0.0
    for axis in (2, 0, 1):
        here = max((abs(float(row[axis])) for forces in (given, commanded) if forces is not None for row in forces), default=0.0)
        if here > most:
            best, most = axis, here
    return best


def _series(run: Any) -> Dict[str, Any]:
    """time, position, given, and where the run has them commanded, balance and balance_time."""
    if isinstance(run, Recording):
        series = _series(run["/hand/sample"])
        if "/hand/account" in run:
            account = run["/hand/account"]
            series.update(balance=account["balance"], balance_time=account["time"])
        return series
    if isinstance(run, Table):
        series = {"time": run["time"], "position": run["position"], "given": run["held"]}
        if "elastic" in run and "frictional" in run:
            series["commanded"] = [[a + b for a, b in zip(*parts)] for parts in zip(run["elastic"], run["frictional"])]
        return series
    if getattr(run, "dtype", None) is not None and run.dtype.names:
        return {"time": run["time"], "position": run["position"], "given": run["force"], "balance": run["balance"],
                "balance_time": run["time"]}
    ticks = list(run) if isinstance(run, (list, tuple)) else []
    if not isinstance(run, (list, tuple)) or not all(hasattr(tick, "force") for tick in ticks):
        raise ValueError(f"plot() draws what Hand.ticks() or feltwire.read() returned, not {run!r}")
    time = [tick.time for tick in ticks]
    return {"time": time, "position": [list(tick.position) for tick in ticks], "given": [list(tick.force) for tick in ticks],
            "balance": [tick.balance for tick in ticks], "balance_time": time}
