#!/usr/bin/env python3
"""Exports recordings that a test wrote, and reads the CSV files and the arrays without numpy; with it, too, where it is.

usage: check_export.py LAB_PROGRAM CLIENT_TEST_PROGRAM SERVER_TEST_PROGRAM
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

SERVER_FILTER = "RecordingForExport.*:FlightRecorderTest.EvictionIsWritten*"
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


def check_server(lab, folder):
    """Two hands for a second, as tests/server/recording/replayed_scene_test.cpp makes them."""
    file = str(folder / "server-TwoHandsAndABody.mcap")
    run(lab, "export", file, "--csv", str(folder / "without"))
    assert not (folder / "without/hand_1_reply.csv").exists()
    run(lab, "export", file, "--replies", "--csv", str(folder / "room"))
    run(lab, "export", file, "--replies", "--npz", str(folder / "room.npz"))
    found = arrays(folder / "room.npz")
    names = sorted(path.name for path in (folder / "room").iterdir())
    assert names == ["hand_1_reply.csv", "hand_1_sample.csv", "hand_2_reply.csv", "hand_2_report.csv", "hand_2_sample.csv",
                     "scene_body_3.csv", "scene_hand_1.csv", "scene_hand_2.csv"], names
    for hand in (1, 2):
        samples = rows(folder / f"room/hand_{hand}_sample.csv")
        assert [int(row["index"]) for row in samples] == list(range(1, 1001))
        for n, row in enumerate(samples, 1):
            assert math.isclose(float(row["t"]), 0.001 * (n - 1), abs_tol=1e-12)
            assert (float(row["x"]), float(row["y"]), float(row["z"])) == (1e-4 * n, 0.02, -1e-6 * n)
            assert [float(row[name]) for name in ("rx", "ry", "rz", "rez", "rfx")] == [0.25, 0, 0.5, 0.5, 0.25]
            # The second hand's samples came two by two.
            came = n if hand == 1 else n + n % 2
            assert int(row["log_time_ns"]) == 1_000_000_000 + 1_000_000 * came, row
            assert found[f"hand_{hand}_sample_position"][2][3 * n - 1] == float(row["z"])
    replies = rows(folder / "room/hand_1_reply.csv")
    assert len(replies) == 1000 and len(rows(folder / "room/hand_2_reply.csv")) == 500
    for n, row in enumerate(replies, 1):
        assert int(row["index"]) == n and math.isclose(float(row["t"]), 0.001 * (n - 1), abs_tol=1e-12)
        assert float(row["ez"]) >= 0 and row["active"] in "01" and row["recovering"] == "0", row
    assert float(replies[999]["ez"]) > 0.01, replies[999]
    reports = rows(folder / "room/hand_2_report.csv")
    assert [row["reasons"] for row in reports] == ["late+account"] * 5
    assert [int(float(row["late_ticks"])) for row in reports] == [1, 2, 3, 4, 5]
    assert math.isnan(float(reports[0]["balance"])) and math.isclose(float(reports[4]["balance"]), 1e-3, rel_tol=1e-6)  # float32 on the wire
    body = rows(folder / "room/scene_body_3.csv")
    assert [float(row["z"]) for row in body] == [1e-3 * (100 * n) for n in range(1, 11)], body
    assert all((float(row["qw"]), float(row["qx"])) == (0.6, 0.8) for row in body)
    shown = rows(folder / "room/scene_hand_1.csv")
    assert len(shown) == 10 and all(math.isclose(float(row["rz"]), 0.5) and math.isclose(float(row["rx"]), 0.25) for row in shown)

    flight = str(folder / "server-EvictionIsWrittenWithTheLastTenSeconds.mcap")
    run(lab, "export", flight, "--csv", str(folder / "flight"))
    for hand in (1, 2):
        times = [int(row["log_time_ns"]) for row in rows(folder / f"flight/hand_{hand}_sample.csv")]
        assert len(times) == 10_001 and times[-1] - times[0] == 10_000_000_000, len(times)
    refused = run(lab, "export", flight, "--replies", "--csv", str(folder / "none"), status=1)
    assert "a replay needs all from the first" in refused and not (folder / "none").exists(), refused


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
    lab, test, server_test = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([test, f"--gtest_filter={FILTER}", "--gtest_brief=1"], check=True,
                       env={**os.environ, "FELTWIRE_KEEP_RECORDINGS": name})
        subprocess.run([server_test, f"--gtest_filter={SERVER_FILTER}", "--gtest_brief=1"], check=True,
                       env={**os.environ, "FELTWIRE_KEEP_RECORDINGS": name})
        check_server(lab, folder)
        said = check_numpy(*check_ticks(lab, folder))

        parts = [str(folder / f"hand-000{i}.mcap") for i in (1, 2, 3)]
        run(lab, "export", *parts, "--csv", str(folder / "hand"))
        assert [float(row["t"]) for row in rows(folder / "hand/hand_sample.csv")] == [0.001 * n for n in range(2500)]

        cut = run(lab, "export", str(folder / "open.mcap"), "--npz", str(folder / "open.npz"))
        assert "was cut at byte" in cut and "/hand/sample: " in cut, cut

        before = (folder / "ticks.mcap").read_bytes()
        damaged = folder / "damaged.mcap"
        several = (folder / "open.mcap").read_bytes()  # of several chunks
        damaged.write_bytes(several[:len(several) // 2] + b"\xff\xff" + several[len(several) // 2 + 2:])
        refused = run(lab, "export", str(damaged), "--npz", str(folder / "none.npz"), status=1)
        assert "damaged.mcap: byte " in refused and "the file is damaged" in refused, refused
        assert "--skip-damaged" in refused and not (folder / "none.npz").exists()
        skipped = run(lab, "export", str(damaged), "--skip-damaged", "--csv", str(folder / "skipped"))
        assert "damaged.mcap: byte " in skipped and "missing: " in skipped, skipped
        run(lab, "export", str(folder / "open.mcap"), "--csv", str(folder / "open"))
        whole, left = rows(folder / "open/hand_sample.csv"), rows(folder / "skipped/hand_sample.csv")
        assert 0 < len(left) < len(whole) and all(row in whole for row in left[::97]), (len(left), len(whole))
        served = (folder / "server-EvictionIsWrittenWithTheLastTenSeconds.mcap").read_bytes()  # with a summary
        damaged.write_bytes(served[:len(served) // 2] + b"\xff\xff" + served[len(served) // 2 + 2:])
        skipped = run(lab, "export", str(damaged), "--skip-damaged", "--csv", str(folder / "served"))
        assert "messages are missing" in skipped, skipped
        refused = run(lab, "export", str(damaged), "--skip-damaged", "--replies", "--csv", str(folder / "none"), status=2)
        same = run(lab, "export", str(folder / "ticks.mcap"), "--npz", str(folder / "ticks.mcap"), status=1)
        assert "name the same file" in same and (folder / "ticks.mcap").read_bytes() == before, same
        assert "--csv DIR or --npz FILE" in run(lab, "export", str(folder / "ticks.mcap"), status=1)
    print(f"exports agree; {said}")


main()
