#!/usr/bin/env python3
"""feltwire.read() against what feltwire-lab exports of the same files, to the last bit."""
import array
import pathlib
import random
import signal
import struct
import subprocess
import tempfile
import unittest
import unittest.mock
import warnings
import zipfile
import zlib

from support import PATIENT, SOURCE, WITHOUT_NUMPY, eventually, run_python
import feltwire
from feltwire import mcap, protobuf, zstd
from feltwire.library import program

RECORD_HEAD = 9  # [bytes] of a record: opcode and length


def npz(path):
    """The arrays of a file of feltwire-lab export, as (shape, numbers as an array of the standard library)."""
    found = {}
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            start = 10 + struct.unpack_from("<H", data, 8)[0]
            head = eval(data[10:start].decode())  # a literal, as numpy itself reads it
            numbers = array.array({"<f8": "d", "<i8": "q"}[head["descr"]])
            numbers.frombytes(data[start:])
            found[name.removesuffix(".npy")] = head["shape"], numbers
    return found


def bits(column, code):
    """The bits of a column, whatever it is made of."""
    rows = column.tolist() if hasattr(column, "tolist") else list(column)
    flat = [one for row in rows for one in row] if rows and isinstance(rows[0], (list, tuple)) else rows
    return array.array(code, flat).tobytes()


def export(path, *more):
    """What feltwire-lab exports of a file, and its complaints; None if it refuses the file."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "all.npz"
        done = subprocess.run([program("feltwire-lab"), "export", path, *more, "--npz", out], capture_output=True, text=True, check=False)
        return (npz(out) if done.returncode == 0 else None), done.stderr


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        flights = cls.folder / "flights"
        with feltwire.serve(SOURCE / "scenes/plane.json", record=cls.folder / "room.mcap", flight_recorder=flights) as server:
            for name in ("hand.mcap", "hand.csv"):
                with server.join(device="simulated:path=taps", duration=2.5, record=cls.folder / name, **PATIENT) as hand:
                    hand.wait()
            server.process.send_signal(signal.SIGUSR1)
            eventually("a flight record", lambda: list(flights.glob("*.mcap")))
        (cls.flight,) = flights.glob("*.mcap")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        warnings.simplefilter("error", feltwire.DamageWarning)

    def assert_equal(self, recording, exported):
        self.assertTrue(exported)
        for name, (shape, numbers) in exported.items():
            _, table, field = name.split("_", 2)
            table = recording[f"/hand/{table}"]
            column = table.log_time if field == "log_time" else table[field]
            self.assertEqual(len(column), shape[0], name)
            self.assertEqual(bits(column, numbers.typecode), numbers.tobytes(), name)

    def test_a_recording_of_a_hand_is_what_the_export_says(self):
        recording = feltwire.read(self.folder / "hand.mcap")
        exported, _ = export(self.folder / "hand.mcap")
        self.assert_equal(recording, exported)
        self.assertEqual(recording.missing, [])
        self.assertEqual((recording.about["scene"], recording.about["device"]), ("plane", "simulated"))
        self.assertEqual(list(recording), ["/hand/account", "/hand/picture", "/hand/pose", "/hand/sample"])
        sample, account = recording["/hand/sample"], recording["/hand/account"]
        self.assertEqual(sample.fields, ["time", "position", "orientation", "elastic", "frictional", "held", "torque", "age"])
        self.assertEqual(len(sample), len(account))
        self.assertEqual(sample.times[0], 0.0)
        self.assertAlmostEqual(sample.times[len(sample) - 1], sample["time"][len(sample) - 1], delta=0.01)
        self.assertIn("felt", account.names("no_force"))
        self.assertEqual(recording["/hand/pose"]["frame_id"][0], "world")
        self.assertEqual(recording["/hand/picture"]["entities"][0][0]["frame_id"], "world")
        with self.assertRaisesRegex(KeyError, "it has time, balance, cut, no_force"):
            account["ballance"]
        with self.assertRaisesRegex(KeyError, "there are /hand/account"):
            recording["/hand/simple"]

    def test_topics_that_nobody_asked_for_are_left_out(self):
        self.assertEqual(list(feltwire.read(self.folder / "hand.mcap", topics=["/hand/sample"])), ["/hand/sample"])
        with self.assertRaisesRegex(ValueError, "'/hand/sampl', and the recording has no such topic; it has /hand/account, /hand/p"):
            feltwire.read(self.folder / "hand.mcap", topics=["/hand/sampl"])

    def test_several_files_are_one_recording(self):
        twice = feltwire.read(self.folder / "hand.mcap", self.folder / "hand.mcap")
        self.assertEqual(len(twice["/hand/sample"]), 2 * len(feltwire.read(self.folder / "hand.mcap")["/hand/sample"]))

    def test_a_recording_and_a_flight_record_of_a_server(self):
        for path in (self.folder / "room.mcap", self.flight):
            recording = feltwire.read(path)
            self.assertEqual(recording.about["scene"], "plane")
            events = recording["/scene/events"]
            numbers = [int(one) for one in events["number"]]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
            self.assertEqual(events.names("kind").count("join"), 2)
            self.assertTrue(any(recording["/scene/picture"]["entities"]))
        self.assertIn(b'"plane"', feltwire.read(self.folder / "room.mcap").attachments["scene-0/plane.json"])

    def test_csv_files(self):
        tables = feltwire.lab.export(self.folder / "hand.mcap").tables
        mcap, csv = feltwire.read(self.folder / "hand.mcap")["/hand/sample"], tables["hand_sample"]
        for field in ("position", "elastic", "frictional", "held", "torque", "orientation", "age", "time"):
            self.assertEqual(bits(mcap[field], "d"), bits(csv[field], "d"), field)
        self.assertEqual(bits(mcap.log_time, "q"), bits(csv.log_time, "q"))
        written = feltwire.read(self.folder / "hand.csv")["/hand/sample"]
        self.assertEqual(written.fields, ["time", "position", "elastic", "frictional", "held", "age"])
        self.assertGreater(len(written), 1000)
        room = feltwire.lab.export(self.folder / "room.mcap").tables
        self.assertGreater(len(room["hand_1_sample"]["held"]), 1000)

    def damaged(self, data):
        path = self.folder / "damaged.mcap"
        path.write_bytes(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", feltwire.DamageWarning)
            return path, feltwire.read(path)

    def test_damaged_files_give_what_is_whole(self):
        """The same parts and the same words as feltwire-lab export --skip-damaged."""
        whole = (self.folder / "hand.mcap").read_bytes()
        seeded = random.Random(7)
        places = [seeded.randrange(8, len(whole)) for _ in range(16)]
        cases = [whole[:place] for place in places[:5]] + [whole[:-4]]
        for place in places[5:]:
            other = (place * 7) % len(whole)
            cases.append(b"".join(bytes([byte ^ 0x55]) if at in (place, other) else bytes([byte]) for at, byte in enumerate(whole)))
        read = 0
        for data in cases:
            (self.folder / "damaged.mcap").write_bytes(data)
            exported, said = export(self.folder / "damaged.mcap", "--skip-damaged")
            if exported is None:
                with self.assertRaises(feltwire.FileError):
                    self.damaged(data)
                continue
            path, recording = self.damaged(data)
            self.assert_equal(recording, exported)
            lines = [line.removeprefix(f"{path}: ") for line in recording.missing]
            self.assertTrue(lines)
            expected = [line.removeprefix(f"feltwire-lab: {path}: ") for line in said.splitlines() if f"{path}: byte" in line]
            self.assertEqual([line for line in lines if line.startswith("byte ")], expected)
            read += 1
        self.assertGreater(read, 8)

    def test_a_damaged_first_chunk_is_told_as_before_the_rest(self):
        data = bytearray((self.folder / "hand.mcap").read_bytes())
        at = len(mcap.MAGIC)
        while data[at] != mcap.CHUNK:
            at += RECORD_HEAD + struct.unpack_from("<Q", data, at + 1)[0]
        end = at + RECORD_HEAD + struct.unpack_from("<Q", data, at + 1)[0]
        data[end - 1] ^= 0x55
        path, recording = self.damaged(bytes(data))
        _, said = export(path, "--skip-damaged")
        self.assertRegex(recording.missing[0], f"byte {at} to {end}: .* before the first message that is whole")
        self.assertIn(recording.missing[0], said)

    def test_a_cut_file_warns(self):
        whole = (self.folder / "hand.mcap").read_bytes()
        (self.folder / "cut.mcap").write_bytes(whole[:-100])
        with self.assertWarnsRegex(feltwire.DamageWarning, r"cut\.mcap: byte \d+ to \d+: "):
            feltwire.read(self.folder / "cut.mcap")

    def test_wrong_files_are_refused_with_the_place_and_the_remedy(self):
        path = self.folder / "wrong.mcap"
        for data, words in ((b"", "byte 0: the file is empty; give one"), (b"hello", "byte 0: this is no MCAP file; give one"),
                            (bytes(5000), "byte 0: this is no MCAP file; give one")):
            path.write_bytes(data)
            with self.assertRaisesRegex(feltwire.FileError, f"wrong.mcap: {words}"):
                feltwire.read(path)
        csv = self.folder / "wrong.csv"
        for text, words in (("hello\n", ":1: this is neither"), ("a,b\n1\n2,3\n", ":2: 1 fields, and the header has 2; give")):
            csv.write_text(text)
            with self.assertRaisesRegex(feltwire.FileError, f"wrong.csv{words}"):
                feltwire.read(csv)
        with self.assertRaises(FileNotFoundError):
            feltwire.read(self.folder / "none.mcap")

    def test_without_numpy_and_without_the_library_the_numbers_are_the_same(self):
        code = WITHOUT_NUMPY + """
import feltwire
table = feltwire.read(sys.argv[1])["/hand/sample"]
print(type(table["time"]).__name__, *[one.hex() for row in table["held"] for one in row])
"""
        kind, *numbers = run_python(code, self.folder / "hand.mcap", FELTWIRE_LIBRARY="/none").split()
        self.assertEqual(kind, "array")
        held = feltwire.read(self.folder / "hand.mcap")["/hand/sample"]["held"]
        self.assertEqual(numbers, [float(one).hex() for row in held for one in row])


class Counted(bytes):
    """Bytes that count how many of them are copied."""
    bytes = 0

    @classmethod
    def note(cls, data):
        cls.bytes += len(data)

    def __getitem__(self, place):
        found = super().__getitem__(place)
        if isinstance(place, slice):
            Counted.bytes += len(found)
        return found


def text(number, value):
    """A field of Protobuf with bytes in it."""
    size = bytes([len(value)]) if len(value) < 128 else bytes([len(value) & 127 | 128, len(value) >> 7])
    return bytes([number << 3 | 2]) + size + value


def record(opcode, content):
    """A record of an MCAP file."""
    return struct.pack("<BQ", opcode, len(content)) + content


def blob(content):
    return struct.pack("<I", len(content)) + content


class Decoding(unittest.TestCase):
    def test_a_file_of_another_program(self):
        """A chunk without compression with its own definitions, two encodings, and no summary."""
        message = text(4, text(1, b"M") + text(2, text(1, b"a") + b"\x18\x01\x20\x01\x28\x01"))
        inside = record(3, struct.pack("<H", 1) + blob(b"M") + blob(b"protobuf") + blob(text(1, message)))
        inside += record(4, struct.pack("<HH", 1, 1) + blob(b"/a") + blob(b"protobuf") + blob(b""))
        inside += record(4, struct.pack("<HH", 2, 0) + blob(b"/b") + blob(b"json") + blob(b""))
        for number, data in ((1, b"\x09" + struct.pack("<d", 2.5)), (2, b"{}"), (1, b"")):
            inside += record(5, struct.pack("<HIQQ", number, 0, 5_000_000_000, 0) + data)
        chunk = struct.pack("<QQQI", 0, 0, len(inside), zlib.crc32(inside)) + blob(b"") + struct.pack("<Q", len(inside)) + inside
        magic = b"\x89MCAP0\r\n"
        data = magic + record(1, blob(b"") + blob(b"")) + record(6, chunk) + record(15, bytes(4)) + record(2, bytes(20)) + magic
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("error", feltwire.DamageWarning)
            path = pathlib.Path(folder) / "other.mcap"
            path.write_bytes(data)
            recording = feltwire.read(path)
            self.assertEqual((list(recording["/a"]["a"]), recording["/b"]["data"], list(recording["/a"].log_time)),
                             ([2.5, 0.0], [b"{}"], [5_000_000_000] * 2))
            path.write_bytes(data.replace(text(1, b"a"), text(1, b"\xff")).replace(struct.pack("<I", zlib.crc32(inside)), bytes(4)))
            with self.assertRaisesRegex(feltwire.FileError, "the schema of /a cannot be read"):
                feltwire.read(path)
            self.assertEqual(list(feltwire.read(path, topics=["/b"])), ["/b"])

    def test_the_search_in_a_hostile_file_is_linear(self):
        """Twice the size is at most some more than twice the bytes that are copied or checked, whatever lies within what."""
        def attachments_in_attachments(count):
            data = bytes(3)
            for _ in range(count):  # each is filled by its fields, has a wrong CRC, and no record follows it
                data = record(9, bytes(16) + blob(b"") + blob(b"") + struct.pack("<Q", len(data)) + data + b"bad!") + b"\xff"
            return data

        def chunks_without_crc(count):
            return b"".join(b"\x06" + struct.pack("<Q", 40 * (count - i)) + bytes(31) for i in range(count))

        def lengths_to_the_end(count):
            return b"".join(b"\x09" + struct.pack("<Q", 9 * (count - i - 1)) for i in range(count))

        def impossible_records(count):
            return count * (record(8, b"") + b"\xff")

        magic = b"\x89MCAP0\r\n"
        for make in (attachments_in_attachments, chunks_without_crc, lengths_to_the_end, impossible_records):
            spent = []
            for count in (400, 800, 1600):
                file = mcap.File(Counted(magic + make(count)))
                with unittest.mock.patch.object(zlib, "crc32", lambda data, *more, crc32=zlib.crc32: Counted.note(data) or crc32(data, *more)):
                    Counted.bytes = 0
                    self.assertEqual(list(file.messages()), [])
                self.assertTrue(file.missing)
                spent.append(Counted.bytes / len(file.data))
            self.assertLess(max(spent), 24.0, make.__name__)  # the head of each record is looked at more than once

    def test_missing_parts_of_many_chunks_are_found_in_few_steps(self):
        class Times(dict):
            looked = 0

            def __getitem__(self, place):
                Times.looked += 1
                return super().__getitem__(place)

            def __iter__(self):
                Times.looked += len(self)
                return super().__iter__()

        file = mcap.File(bytes(100_000))
        file._times = Times((place, (place, place + 1)) for place in range(0, 100_000, 50))
        file._places = sorted(file._times)
        Times.looked = 0
        for begin in range(0, 100_000, 100):
            file._miss(begin, begin + 100, "damaged", False)
        file._judge_end(100_000, True, set())
        self.assertEqual(file.missing[1].times, (100, 151))
        self.assertEqual(len(file.missing), 1001)  # and the summary
        self.assertLess(Times.looked, 3000)

    def test_what_chunks_decompress_to_is_limited(self):
        inside = record(4, struct.pack("<HH", 2, 0) + blob(b"/b") + blob(b"json") + blob(b""))
        inside += record(5, struct.pack("<HIQQ", 2, 0, 5, 0) + b"{}" + 1000 * b" ")
        chunk = record(6, struct.pack("<QQQI", 0, 0, len(inside), 0) + blob(b"") + struct.pack("<Q", len(inside)) + inside)
        magic = b"\x89MCAP0\r\n"
        data = magic + record(1, blob(b"") + blob(b"")) + 3 * chunk + record(15, bytes(4)) + record(2, bytes(20)) + magic
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("error", feltwire.DamageWarning)
            path = pathlib.Path(folder) / "large.mcap"
            path.write_bytes(data)
            for enough in (None, 3 * len(inside)):
                self.assertEqual(len(feltwire.read(path, max_bytes=enough)["/b"]), 3)
            for paths, limit in (([path], 3 * len(inside) - 1), ([path, path], 5 * len(inside))):
                with self.assertRaisesRegex(feltwire.FileError, rf"large.mcap: its chunks decompress to more than {limit} bytes; allow more with"):
                    feltwire.read(*paths, max_bytes=limit)

    def test_what_is_no_zstd_frame_is_refused(self):
        with self.assertRaises(ValueError):
            zstd.decompress(b"no frame", 10)

    def test_messages_of_any_shape(self):
        """string name = 1; repeated int32 many = 2 (packed); sint64 zigzag = 3; bool yes = 4; float half = 5; optional double maybe = 6;
        Inner inside = 7 { fixed32 a = 1; }"""
        def field(name, number, kind, label=1, optional=False, of=b""):
            return text(2, text(1, name) + bytes([3 << 3, number, 4 << 3, label, 5 << 3, kind]) + (text(6, of) if of else b"")
                        + (b"\x88\x01\x01" if optional else b""))

        inner = text(4, text(1, b"Inner") + field(b"a", 1, 7))
        outer = text(4, text(1, b"Outer") + field(b"name", 1, 9) + field(b"many", 2, 5, 3) + field(b"zigzag", 3, 18) + field(b"yes", 4, 8)
                     + field(b"half", 5, 2) + field(b"maybe", 6, 1, optional=True) + field(b"inside", 7, 11, of=b".p.Inner"))
        rows = protobuf.Rows(protobuf.Types(text(1, text(2, b"p") + inner + outer)), "p.Outer")
        rows.extend([b"", text(1, b"x") + text(2, b"\x01\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01") + b"\x18\x03\x20\x01\x2d" + struct.pack("<f", 0.5)
                     + b"\x31" + struct.pack("<d", 2.5) + text(7, b"\x0d" + struct.pack("<I", 9)) + b"\xa0\x06\x05"])
        found = {column.name: list(rows.data[column.slot]) for column in rows.columns}
        self.assertNotEqual(found["maybe"][0], found["maybe"][0])
        del found["maybe"][0]
        self.assertEqual(found, {"name": ["", "x"], "many": [[], [1, -1]], "zigzag": [0, -2], "yes": [0, 1], "half": [0, 0.5], "maybe": [2.5],
                                 "inside.a": [0, 9]})
        for hostile in (b"\x0a\xff", b"\x08", b"\xff" * 11, b"\x0b", b"\x31\x00", text(7, b"\x0d\x00")):
            with self.assertRaises((ValueError, IndexError)):
                rows.extend([hostile])

    def test_a_small_schema_with_billions_of_fields_is_refused(self):
        """Each message has two of the next kind."""
        def field(number, of):
            return text(2, text(1, b"f%d" % number) + bytes([3 << 3, number, 4 << 3, 1, 5 << 3, 11]) + text(6, of))

        kinds = [text(4, text(1, b"M%d" % i) + field(1, b".p.M%d" % (i + 1)) + field(2, b".p.M%d" % (i + 1))) for i in range(32)]
        last = text(4, text(1, b"M32") + text(2, text(1, b"a") + b"\x18\x01\x20\x01\x28\x01"))
        with self.assertRaisesRegex(ValueError, "more than 4096 fields"):
            protobuf.Rows(protobuf.Types(text(1, text(2, b"p") + b"".join(kinds) + last)), "p.M0")

    def test_csv_of_other_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "other.csv"
            path.write_bytes(b"\xef\xbb\xbft,x\n0.5,1\n")
            self.assertEqual(list(feltwire.read(path)["other"]["x"]), [1.0])
            self.assertNotIn("\ufefft", feltwire.read(path)["other"].fields)
            path.write_bytes(b"t,x\n0.5," + 200000 * b"1" + b"\n")
            with self.assertRaisesRegex(feltwire.FileError, r"other.csv:2: .*give a CSV file"):
                feltwire.read(path)

    def test_shapes_that_repeat(self):
        """The same bytes between other numbers, zeros that are left out, and a number of one byte that becomes two."""
        body = text(1, b"M") + text(2, text(1, b"a") + b"\x18\x01\x20\x01\x28\x01") + text(2, text(1, b"n") + b"\x18\x02\x20\x01\x28\x05")
        rows = protobuf.Rows(protobuf.Types(text(1, text(4, body))), "M")
        values = [(1.5, 3), (2.5, 4), (0.0, 5), (-0.0, 127), (3.5, 128), (4.5, 0), (5.5, -1), (6.5, 7)]
        for value, number in values:
            varint, rest = b"", number & 0xFFFFFFFFFFFFFFFF
            while rest > 127:
                varint, rest = varint + bytes([rest & 127 | 128]), rest >> 7
            message = b"\x09" + struct.pack("<d", value) if struct.pack("<d", value) != bytes(8) else b""
            rows.extend([message + (b"\x10" + varint + bytes([rest]) if number else b"")])
        self.assertEqual(rows.data[0].tobytes(), struct.pack("<8d", *[value for value, _ in values]))
        self.assertEqual(list(rows.data[1]), [number for _, number in values])


if __name__ == "__main__":
    unittest.main()
