"""Reads recordings of clients and servers, and flight records."""
from __future__ import annotations

import mmap
import os
import pathlib
import struct
import warnings
from array import array
from typing import Any, Collection, Dict, Iterator, List, Optional, Set, Tuple, Union

from . import mcap
from .errors import FileError
from .mcap_records import MAGIC, Channel
from .protobuf import Rows, Types
from .tables import Table, from_csv, numpy_or_none, vectors

Path = Union[str, "os.PathLike[str]"]
# The errors of messages and schemas that are not what they say.
_MALFORMED = (ValueError, LookupError, TypeError, AttributeError, OverflowError, RecursionError, struct.error)


class DamageWarning(UserWarning):
    """A recording is damaged or cut. What is whole was read."""


class Recording:
    """What read() found in the files. recording["/hand/sample"] is the Table of a topic.

    topics: the tables by topic. about: client, device, scene, server and version, as the metadata record `feltwire` has them; empty in a
    CSV file. metadata: all metadata records, (name, values), in the file's order. attachments: files in the file, by name. missing: a line
    for each part that could not be read; empty: the recording is whole.
    """

    def __init__(self, topics: Dict[str, Table], metadata: List[Tuple[str, Dict[str, str]]], attachments: Dict[str, bytes],
                 missing: List[str]):
        self.topics, self.metadata, self.attachments, self.missing = topics, metadata, attachments, missing
        self.about: Dict[str, str] = next((values for name, values in metadata if name == "feltwire"), {})

    def __getitem__(self, topic: str) -> Table:
        if topic not in self.topics:
            raise KeyError(f"there is no topic {topic}; there are {', '.join(self.topics) or 'none'}")
        return self.topics[topic]

    def __contains__(self, topic: object) -> bool:
        return topic in self.topics

    def __iter__(self) -> Iterator[str]:
        return iter(self.topics)

    def __len__(self) -> int:
        return len(self.topics)

    def __repr__(self) -> str:
        return "\n".join(repr(table) for table in self.topics.values()) or "<an empty recording>"


def read(*paths: Path, topics: Optional[Collection[str]] = None, max_bytes: Optional[int] = 4 << 30) -> Recording:
    """Reads a recording: the MCAP files of one recording in their order, or a CSV file (docs/recording.md).

    topics: only these; without it all. Raises ValueError with the topics that there are if one of them is not in the recording. max_bytes:
    to which the chunks of all files may decompress, None for any number: a small file can ask for a lot of memory. Units are SI, values are
    in the world frame, quaternions are w, x, y, z. Columns are NumPy arrays;
    without NumPy arrays and lists of the standard library. An optional number that a message does not have is not a number.

    A damaged or cut file gives what is whole in it, and a DamageWarning; Recording.missing lists the rest. Raises FileError for a file
    with nothing whole in it, of another kind, or larger than max_bytes, and OSError where it cannot be opened.
    """
    if not paths:
        raise ValueError("read() takes at least one path")
    if len(paths) == 1 and not _is_mcap(paths[0]):
        return _read_csv(pathlib.Path(paths[0]))
    reader = _Reader(topics, max_bytes)
    for path in paths:
        reader.add(pathlib.Path(path))
    return reader.recording()


def _is_mcap(path: Path) -> bool:
    with open(path, "rb") as file:
        begin = file.read(4096)
    return pathlib.Path(path).suffix == ".mcap" or (bool(begin) and MAGIC.startswith(begin[:len(MAGIC)])) or b"\0" in begin


class _Topic:
    """The messages of a topic so far."""

    def __init__(self, channel: Channel, types: Optional[Types], name: str):
        self.channel = channel
        self.rows = Rows(types, name) if types is not None else None
        self.raw: List[bytes] = []
        self.log_time = array("Q")

    def table(self, first: int) -> Table:
        numpy = numpy_or_none()
        columns: Dict[str, Any] = {}
        enums: Dict[str, Dict[int, str]] = {}
        if self.rows is None:
            columns["data"] = self.raw
        else:
            for column in self.rows.columns:
                parts = self.rows.data[column.slot:column.slot + column.width]
                if column.code and numpy:
                    kind = {"d": numpy.float64, "q": numpy.int64, "Q": numpy.uint64}[column.code]
                    arrays = [numpy.frombuffer(part, dtype=kind) if len(part) else numpy.empty(0, dtype=kind) for part in parts]
                    columns[column.name] = arrays[0] if column.width == 1 else numpy.column_stack(arrays)
                else:
                    columns[column.name] = parts[0] if column.width == 1 else list(zip(*parts))
                if column.enum:
                    enums[column.name] = column.enum
        times: Any = array("d", (1e-9 * (time - first) for time in self.log_time))
        log_time: Any = self.log_time
        if numpy:
            times, log_time = (numpy.array(one) for one in (times, log_time))
        return Table(self.channel.topic, columns, times, log_time, enums)


class _Reader:
    """Reads the files of a recording one after the other."""

    def __init__(self, wanted: Optional[Collection[str]], max_bytes: Optional[int]):
        self._seen: Set[str] = set()
        self._wanted, self._max_bytes = wanted, max_bytes
        self._allowed = max_bytes  # [bytes] for the files to come
        self._topics: Dict[str, _Topic] = {}
        self._metadata: List[Tuple[str, Dict[str, str]]] = []
        self._attachments: Dict[str, bytes] = {}
        self._missing: List[str] = []
        self._first: Optional[int] = None  # [ns] log time

    def add(self, path: pathlib.Path) -> None:
        with open(path, "rb") as opened:
            size = os.fstat(opened.fileno()).st_size
            if size == 0:
                raise FileError(f"{path}: byte 0: the file is empty; give one that --record wrote")
            with mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ) as data:
                file = mcap.File(data, allowed=self._allowed)
                try:
                    self._add_messages(path, file)
                except mcap.TooLarge:
                    raise FileError(f"{path}: its chunks decompress to more than {self._max_bytes} bytes; allow more with read(..., max_bytes=N), "
                                    "or leave topics out of the recording") from None
                self._allowed = file.allowed
                if file.found == 0 and file.missing and not data[:len(MAGIC)] == MAGIC[:size]:
                    raise FileError(f"{path}: byte 0: this is no MCAP file; give one that --record wrote")
                if file.found == 0 and file.missing and file.missing[0].end > file.missing[0].begin:
                    raise FileError(f"{path}: byte {file.missing[0].begin}: {file.missing[0].what}, and no message is whole; copy the file anew "
                                    "from where it was recorded")
        self._seen |= {channel.topic for channel in file.channels.values()}
        self._metadata += file.metadata
        self._attachments.update(file.attachments)
        if file.missing:
            lines = [f"{path}: {part.text(self._first)}" for part in file.missing]
            if file.counted is not None and file.counted > file.found:
                lines.append(f"{path}: {file.counted - file.found} of {file.counted} messages are missing")
            self._missing += lines
            warnings.warn("\n".join(lines), DamageWarning, stacklevel=4)

    def _add_messages(self, path: pathlib.Path, file: mcap.File) -> None:
        known: Dict[int, Optional[_Topic]] = {}
        for messages in file.messages():
            if self._first is None:
                self._first = messages[0].log_time
            batches: Dict[int, List[bytes]] = {}
            for message in messages:
                if message.channel not in known:
                    known[message.channel] = self._topic(path, file, message.channel)
                topic = known[message.channel]
                if topic is not None:
                    topic.log_time.append(message.log_time)
                    batches.setdefault(message.channel, []).append(message.data)
            for number, batch in batches.items():
                self._extend(path, known[number], batch)

    @staticmethod
    def _extend(path: pathlib.Path, topic: Any, batch: List[bytes]) -> None:
        if topic.rows is None:
            topic.raw += batch
            return
        try:
            topic.rows.extend(batch)
        except _MALFORMED as error:
            raise FileError(f"{path}: a message of {topic.channel.topic} is not as its schema says ({error}); leave the topic out with "
                            "read(..., topics=[...])") from None

    def _topic(self, path: pathlib.Path, file: mcap.File, number: int) -> Optional[_Topic]:
        """The topic of a channel, or None if nobody asked for it."""
        channel = file.channels[number]
        if self._wanted is not None and channel.topic not in self._wanted:
            return None
        known = self._topics.get(channel.topic)
        if known is not None:
            return known
        schema = file.schemas.get(channel.schema)
        try:
            types = Types(schema.data) if schema is not None and channel.message_encoding == schema.encoding == "protobuf" else None
            topic = self._topics[channel.topic] = _Topic(channel, types, schema.name if schema else "")
        except _MALFORMED as error:
            raise FileError(f"{path}: the schema of {channel.topic} cannot be read ({error}); leave the topic out with "
                            "read(..., topics=[...])") from None
        return topic

    def recording(self) -> Recording:
        for topic in self._wanted or ():
            if self._seen and topic not in self._seen:
                raise ValueError(f"topics has {topic!r}, and the recording has no such topic; it has {', '.join(sorted(self._seen))}")
        first = self._first or 0
        return Recording({name: self._topics[name].table(first) for name in sorted(self._topics)}, self._metadata, self._attachments,
                         self._missing)


def _read_csv(path: pathlib.Path) -> Recording:
    """A CSV file: of a client's recording as /hand/sample, of any other with the topic of its name."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = file.readlines()
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: byte {error.start}: this is neither an MCAP file nor CSV; give one that --record wrote") from None
    if not lines or "," not in lines[0]:
        raise FileError(f"{path}:1: this is neither an MCAP file nor CSV with a header; give one that --record wrote")
    columns = from_csv(lines, str(path))
    missing = [f"{path}: the file ends within a line"] if not lines[-1].endswith("\n") else []
    if missing:
        warnings.warn(missing[0], DamageWarning, stacklevel=3)
    topic = "/hand/sample" if {"t", "x", "y", "z", "rx", "age"} <= set(columns) else path.stem
    fields = vectors(columns)
    table = Table(topic, fields, fields.get("time"), fields.get("log_time_ns"))
    return Recording({topic: table}, [], {}, missing)
