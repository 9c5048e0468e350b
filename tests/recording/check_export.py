#!/usr/bin/env python3
"""Exports recordings that a test wrote, and reads the CSV files and the arrays without numpy; with it, too, where it is.

usage: check_export.py LAB_PROGRAM TEST_PROGRAM
"""

import csv
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile

FILTER = "McapRecording.HasAllOfEachTick:McapRecording.FilesAreNumberedByTime:McapRecording.IsReadable*"


def array(data):
    """A .npy file: (type, shape, numbers)."""
    assert data[:8] == b"\x93NUMPY\x01\x00", data[:8]
    (length,) = struct.unpack_from("<H", data, 8)
    start = 10 + length
    assert start % 64 == 0 and data[start - 1:start] == b"\n"
    head = eval(data[10:start].decode())  # a literal, as numpy itself reads it
    count = math.prod(head["shape"])
    assert not head["fortran_order"] and len(data) == start + 8 * count, head
    kind = {"<f8": "d", "<i8": "q"}[head["descr"]]
    return head["descr"], head["shape"], struct.unpack_from(f"<{count}{kind}", data, start)


def arrays(file):
    with zipfile.ZipFile(file) as archive:
        assert archive.testzip() is None
        return {name.removesuffix(".npy"): array(archive.read(name)) for name in archive.namelist()}


def rows(file):
    with open(file, newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def run(*command, status=0):
    ran = subprocess.run(command, text=True, capture_output=True)
    assert ran.returncode == status, (command, ran)
    return ran.stdout + ran.stderr


def check_ticks(lab, folder):
    """A thousand ticks, as tests/client/run/mcap_recording_test.cpp makes them."""
    run(lab, "export", str(folder / "ticks.mcap"), "--npz", str(folder / "ticks.npz"))
    run(lab, "export", str(folder / "ticks.mcap"), "--csv", str(folder / "ticks"))
    found = arrays(folder / "ticks.npz")
    shapes = {name: shape for name, (_, shape, _) in found.items()}
    assert shapes == {
        "hand_sample_time": (1000,), "hand_sample_position": (1000, 3), "hand_sample_elastic": (1000, 3),
        "hand_sample_frictional": (1000, 3), "hand_sample_held": (1000, 3), "hand_sample_age": (1000,),
        "hand_sample_orientation": (1000, 4), "hand_sample_torque": (1000, 3), "hand_sample_log_time": (1000,),
        "hand_account_time": (1000,), "hand_account_balance": (1000,), "hand_account_cut": (1000,),
        "hand_account_no_force": (1000,), "hand_account_log_time": (1000,)}, shapes
    value = {name: numbers for name, (_, _, numbers) in found.items()}
    assert found["hand_sample_log_time"][0] == "<i8"
    samples, accounts = rows(folder / "ticks/hand_sample.csv"), rows(folder / "ticks/hand_account.csv")
    assert len(samples) == len(accounts) == 1000
    for n in range(1000):
        depth = 1e-3 * math.sin(0.01 * n)
        assert value["hand_sample_time"][n] == 0.001 * n
        assert value["hand_sample_log_time"][n] == 1_700_000_000_000_000_000 + 1_000_000 * n
        assert value["hand_sample_position"][3 * n] == 0.01
        assert math.isclose(value["hand_sample_position"][3 * n + 2], -depth, abs_tol=1e-15)
        assert math.isclose(value["hand_sample_held"][3 * n + 2], 900 * depth, abs_tol=1e-12)
        assert value["hand_sample_orientation"][4 * n:4 * n + 4] == (0.6, 0.8, 0.0, 0.0)
        balance = value["hand_account_balance"][n]
        assert math.isnan(balance) if n < 10 else balance == 1e-6 * n
        assert value["hand_account_no_force"][n] == (0 if n % 2 == 0 else 20)
        # The text reads back to the same bits.
        assert float(samples[n]["z"]) == value["hand_sample_position"][3 * n + 2]
        assert float(samples[n]["rz"]) == value["hand_sample_held"][3 * n + 2]
        assert int(samples[n]["log_time_ns"]) == value["hand_sample_log_time"][n]
        assert accounts[n]["no_force"] == ("felt" if n % 2 == 0 else "account")
    return folder / "ticks.npz", value


def check_numpy(file, value):
    try:
        import numpy
    except ImportError:
        return "numpy is not here and was not asked"
    with numpy.load(file) as found:
        for name in found:
            assert numpy.array_equal(found[name].ravel(), value[name], equal_nan=True), name
    return "numpy agrees"


def main():
    lab, test = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([test, f"--gtest_filter={FILTER}", "--gtest_brief=1"], check=True,
                       env={**os.environ, "FELTWIRE_KEEP_RECORDINGS": name})
        said = check_numpy(*check_ticks(lab, folder))

        parts = [str(folder / f"hand-000{i}.mcap") for i in (1, 2, 3)]
        run(lab, "export", *parts, "--csv", str(folder / "hand"))
        assert [float(row["t"]) for row in rows(folder / "hand/hand_sample.csv")] == [0.001 * n for n in range(2500)]

        cut = run(lab, "export", str(folder / "open.mcap"), "--npz", str(folder / "open.npz"))
        assert "was cut at byte" in cut and "/hand/sample: " in cut, cut

        before = (folder / "ticks.mcap").read_bytes()
        damaged = folder / "damaged.mcap"
        damaged.write_bytes(before[:len(before) // 2] + b"\xff\xff" + before[len(before) // 2 + 2:])
        refused = run(lab, "export", str(damaged), "--npz", str(folder / "none.npz"), status=1)
        assert "damaged.mcap: byte " in refused and "the file is damaged" in refused, refused
        assert not (folder / "none.npz").exists()
        same = run(lab, "export", str(folder / "ticks.mcap"), "--npz", str(folder / "ticks.mcap"), status=1)
        assert "name the same file" in same and (folder / "ticks.mcap").read_bytes() == before, same
        assert "--csv DIR or --npz FILE" in run(lab, "export", str(folder / "ticks.mcap"), status=1)
    print(f"exports agree; {said}")


main()
