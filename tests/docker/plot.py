"""One picture a client: where its hand was, what it felt, and how old that was."""

import subprocess

SCRIPT = """
set terminal pngcairo size 1200,900 font "sans,11"
set output "{picture}"
set datafile separator ","
set multiplot layout 3,1 title "{title}" font ",14"
set lmargin 10
set rmargin 18
set grid
set key outside right top samplen 2
set xrange [0:*]
set ylabel "position [mm]"
plot "{data}" using "t":(column("x")*1e3) with lines lw 1.5 title "x", \\
     "" using "t":(column("y")*1e3) with lines lw 1.5 title "y", \\
     "" using "t":(column("z")*1e3) with lines lw 1.5 title "z"
set ylabel "force [N]"
plot "{data}" using "t":(sqrt((column("ex")+column("fx"))**2+(column("ey")+column("fy"))**2+(column("ez")+column("fz"))**2)) \\
       with lines lw 1 lc rgb "#b0b0b0" title "commanded", \\
     "" using "t":(sqrt(column("rx")**2+column("ry")**2+column("rz")**2)) with lines lw 1.5 lc rgb "#c03020" title "held"
set ylabel "age of the command [ms]"
set xlabel "time [s]"
set logscale y
set yrange [0.01:*]
plot "{data}" using "t":(column("age")>0 ? column("age")*1e3 : NaN) with points pt 7 ps 0.15 lc rgb "#3060a0" notitle
unset multiplot
"""


def plot(recording, title):
    """Draws FILE.csv into FILE.png; the script stays beside it."""
    script = recording.with_suffix(".gp")
    script.write_text(SCRIPT.format(picture=recording.with_suffix(".png").name, data=recording.name,
                                    title=title.replace("_", " ")))
    done = subprocess.run(["gnuplot", script.name], cwd=recording.parent, capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        raise RuntimeError(f"gnuplot {script}: {done.stderr.strip()}")
