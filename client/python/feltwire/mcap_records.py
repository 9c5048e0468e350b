"""The records of an MCAP file (https://mcap.dev/spec)."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Optional, Tuple

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = range(9, 16)


class Schema(NamedTuple):
    """The description of the messages of a channel."""
    name: str
    encoding: str
    data: bytes


class Channel(NamedTuple):
    """A topic of the file."""
    schema: int
    topic: str
    message_encoding: str
    metadata: Dict[str, str]


class Message(NamedTuple):
    """A message and its time."""
    channel: int
    log_time: int  # [ns]
    data: bytes


class Damage(ValueError):
    """A record that is not whole."""


@dataclass
class Missing:
    """A part of a file that cannot be read."""
    begin: int  # [bytes]
    end: int  # [bytes]
    what: str
    times: Optional[Tuple[int, int]] = None  # [ns] log time of the first and the last message in it, if the file still says so

    def text(self, first: Optional[int]) -> str:
        """A line about it. first [ns]: log time from which times are counted."""
        line = f"byte {self.begin} to {self.end}: {self.what}"
        if self.times is None:
            return line
        since = [1e-9 * (time - (first or 0)) for time in self.times]
        if first is not None and self.times[1] < first:
            return f"{line}; missing: {-since[0]:.3f} s to {-since[1]:.3f} s before the first message that is whole"
        return f"{line}; missing: {since[0]:.3f} s to {since[1]:.3f} s" + ("" if first is None else " of the recording")


class Fields:
    """Takes values off the front of a record. Raises Damage where the record ends too early."""

    def __init__(self, data: bytes):
        self.data, self.at = data, 0

    def take(self, size: int) -> bytes:
        if size > len(self.data) - self.at:
            raise Damage("a record ends within a field")
        self.at += size
        return self.data[self.at - size:self.at]

    def number(self, size: int) -> int:
        return int.from_bytes(self.take(size), "little")

    def blob(self) -> bytes:
        return self.take(self.number(4))

    def text(self) -> str:
        return bytes(self.blob()).decode(errors="replace")

    def map(self) -> Dict[str, str]:
        inside, found = Fields(self.blob()), {}
        while inside.at < len(inside.data):
            key = inside.text()
            found[key] = inside.text()
        return found

    def end(self) -> None:
        if self.at != len(self.data):
            raise Damage("the length of a record is damaged")


def is_known(opcode: int) -> bool:
    return HEADER <= opcode <= DATA_END or opcode >= 0x80


def check_filled(opcode: int, content: Any) -> None:
    """A record that is longer than its fields would hide those after it. content: bytes, or a view of them, of which nothing is copied."""
    fields = Fields(content)
    if opcode in (HEADER, METADATA):
        texts = 2
    elif opcode == SCHEMA:
        fields.take(2)
        texts = 3
    elif opcode == CHANNEL:
        fields.take(4)
        texts = 3
    elif opcode == MESSAGE_INDEX:
        fields.take(2)
        texts = 1
    elif opcode == ATTACHMENT:
        fields.take(16)
        fields.blob()
        fields.blob()
        fields.take(fields.number(8))
        fields.take(4)
        texts = 0
    elif opcode == CHUNK:
        fields.take(28)
        fields.blob()
        fields.take(fields.number(8))
        texts = 0
    else:
        return
    for _ in range(texts):
        fields.blob()
    fields.end()
