#!/usr/bin/env python3
"""scripts/plot-recording draws the axis of the largest force, if it is told none. A program in place of gnuplot, which draws where there is
no matplotlib, writes down which one it is told.

The pictures of feltwire-lab figures show each curve, also where two are equal: what is commanded is dashed and lies over what is rendered.
Their legends name every curve, and say which energy the paper means.

usage: check_plot.py SOURCE_FOLDER BIN_FOLDER
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

HEAD = "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age"
# (rows of elastic, frictional and given force, the axis that is drawn)
CASES = [
    ([[0, 0, 2, 0, 0, 0, 0, 0, 2]], "z"),
    ([[0, -3, 2, 0, 0, 0, 0, -3, 2]], "y"),
    ([[1, 0, 0, 2.5, 0, 0, 1, 0, 0], [0, 0, 3, 0, 0, 0, 0, 0, 3]], "x"),  # both parts of a command count
    ([[0, 0, 1, 0, 0, 0, -4, 0, 1]], "x"),                                # and what the hand was given
    ([[0, 0, 0, 0, 0, 0, 0, 0, 0]], "z"),
    ([[1e-9, 2e-9, 0, 0, 0, 0, 0, 0, 0]], "y"),
]


def figures(lab):
    """Yields each fault of the scripts of the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([str(lab), "figures", "--out", folder], check=True, stdout=subprocess.DEVNULL)
        scripts = {file.stem: file.read_text() for file in pathlib.Path(folder).glob("*.gp")}
    styles = dict(re.findall(r"set style line (\d+) ([^\n]*)", scripts["figure2"]))
    drawn = 0
    for name in ("figure2", "figure3", "summary"):
        for plot in re.findall(r"(?m)^plot ([^\n]*'commanded'[^\n]*)$", scripts[name]):
            drawn += 1
            curves = re.findall(r"with lines ls (\d+) title '([^']*)'", plot)
            if [title for _, title in curves] != ["rendered", "commanded"]:
                yield f"{name}: the curves {curves} of a force: the commanded one is drawn last"
            elif " dt " not in styles[curves[1][0]] or " dt " in styles[curves[0][0]]:
                yield f"{name}: the commanded force is not dashed, or the rendered one is"
    if drawn != 2 + 2 + 6:
        yield f"{drawn} plots of forces"
    for name in ("figure2", "figure3"):
        if scripts[name].count("F(n-1) dx(n): the port, and the paper") != 2:
            yield f"{name}: does not say which energy the paper means"
    dotted = {name: "normal of the sphere" for name in ("figure5", "figure6", "sphere_modes")}
    dotted |= {name: "correct direction" for name in ("torque_figure5", "torque_figure6", "torque_modes")}
    for name, title in dotted.items():
        if "notitle" in scripts[name] or scripts[name].count("dt 3") != scripts[name].count(f"title '{title}'"):
            yield f"{name}: a curve is not in the legend"


def main():
    script = pathlib.Path(sys.argv[1]).resolve() / "scripts/plot-recording"
    wrong = list(figures(pathlib.Path(sys.argv[2]) / "feltwire-lab"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        gnuplot = folder / "gnuplot"
        gnuplot.write_text('#!/bin/sh\ncat >/dev/null\necho "axis $AXIS" >"$PICTURE"\n')
        gnuplot.chmod(0o755)
        (folder / "matplotlib.py").write_text("raise ImportError\n")
        picture = folder / "out.png"
        environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "PYTHONPATH": str(folder)}

        def drawn(recording, *axis):
            picture.unlink(missing_ok=True)
            done = subprocess.run([str(script), str(recording), str(picture), *axis], env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            return done.returncode, picture.read_text().strip() if picture.exists() else done.stdout.strip()

        for ends in ("\n", "\r\n"):
            for rows, axis in CASES:
                recording = folder / "hand.csv"
                lines = [HEAD] + [",".join(map(str, [0.001 * i, 0, 0, 0, *row, 0])) for i, row in enumerate(rows)]
                recording.write_bytes((ends.join(lines) + ends).encode())
                if (seen := drawn(recording)) != (0, f"axis {axis}"):
                    wrong.append(f"{rows}: {axis}, not {seen}")
                if (seen := drawn(recording, "x")) != (0, "axis x"):
                    wrong.append(f"{rows} with the axis x: {seen}")
        recording.write_text("t,x,y,z\n0,0,0,0\n")
        status, said = drawn(recording)
        if status != 1 or "has no ticks of a hand; give a file" not in said:
            wrong.append(f"a file without forces: {status} {said}")
        recording = folder / "hand.mcap"
        recording.write_bytes(b"\x89MCAP0\r\n" + bytes(40))
        status, said = drawn(recording)
        if status != 1 or str(recording) not in said:
            wrong.append(f"an MCAP file: {status} {said}")
        if drawn(recording, "w")[0] != 2:
            wrong.append("the axis w is taken")
    print("\n".join(wrong + [f"{2 * len(CASES)} recordings, {len(wrong)} wrong"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
