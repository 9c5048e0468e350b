"""Pictures of a hand's run, with matplotlib."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict, Optional, Union

from .errors import Error
from .recordings import Recording
from .tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_AXES = "xyz"


def plot(run: Any, path: Optional[Union[str, "os.PathLike[str]"]] = None, *, axis: Optional[str] = None) -> "Figure":
    """Draws where the hand was [mm], its force [N] and the balance of its energy account [mJ], over time [s]. Returns the Figure.

    run: what Hand.ticks() returned, a Recording of read(), or a Table with the fields time, position and held. A recording also has the
    force that the scene commanded. axis: "x", "y" or "z"; without it that of the largest force. path: the picture is written there, as
    PNG or what its name says; without it matplotlib.pyplot shows it: pyplot.show(), or by itself in a notebook.

    Raises Error where matplotlib is not installed, and ValueError for a run without ticks or another axis.
    """
    try:
        import numpy
        from matplotlib.figure import Figure
    except ImportError:
        raise Error("plot() needs matplotlib; install python3-matplotlib, or the Python package matplotlib") from None
    if axis is not None and axis not in ("x", "y", "z"):
        raise ValueError(f"the axis {axis!r} is not x, y or z")
    series = {name: numpy.asarray(values, dtype=float) for name, values in _series(run).items()}
    time, position, given = series["time"], series["position"], series["given"]
    if not len(time):
        raise ValueError("the run has no ticks")
    commanded = series.get("commanded")
    along = _AXES.index(axis) if axis else largest_axis(given, commanded)
    name = _AXES[along]
    balance = series.get("balance")
    has_balance = balance is not None and bool(numpy.isfinite(balance).any())
    rows = 3 if has_balance else 2
    if path is None:
        from matplotlib import pyplot
        figure = pyplot.figure(figsize=(9, 2.4 * rows), layout="constrained")
    else:
        figure = Figure(figsize=(9, 2.4 * rows), layout="constrained")
    panels = figure.subplots(rows, 1, sharex=True)
    panels[0].plot(time, 1e3 * position[:, along], color="#1f4e79")
    panels[0].set_ylabel(f"{name} of the hand [mm]")
    if commanded is not None:
        panels[1].plot(time, commanded[:, along], color="#e8a33d", linewidth=3, label="commanded by the scene")
    panels[1].plot(time, given[:, along], color="#a02020", linewidth=1, label="given to the hand")
    panels[1].set_ylabel(f"force along {name} [N]")
    if commanded is not None:
        panels[1].legend(loc="best")
    if balance is not None and has_balance:
        panels[2].plot(series["balance_time"], 1e3 * balance, color="#2e7d32")
        panels[2].set_ylabel("balance of the account [mJ]")
    for panel in panels:
        panel.grid(True, alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    if path is not None:
        figure.savefig(path, dpi=120)
    return figure


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
    import numpy
    if isinstance(run, Recording):
        series = _series(run["/hand/sample"])
        if "/hand/account" in run:
            account = run["/hand/account"]
            series.update(balance=account["balance"], balance_time=account["time"])
        return series
    if isinstance(run, Table):
        series = {"time": run["time"], "position": run["position"], "given": run["held"]}
        if "elastic" in run and "frictional" in run:
            series["commanded"] = numpy.asarray(run["elastic"]) + numpy.asarray(run["frictional"])
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
