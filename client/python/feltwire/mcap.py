"""What is whole in an MCAP file, the container of recordings.

A record is whole if its lengths fit, its CRC is right and its content can be read. After a damaged one the search goes on behind it; if
its length is damaged too, at the next record that cannot be in a chunk. feltwire-lab export --skip-damaged finds the same.

The work is in proportion to the size of the file, whatever is in it: nothing is copied to look for a record, and the bytes of damaged records
that are read again, because the search goes on within them, are counted.
"""
from __future__ import annotations

import bisect
import mmap
import re
import struct
import zlib
from dataclasses import dataclass, field
from typing import Dict, Iterator, List, Optional, Set, Tuple, Union

from . import zstd
from .mcap_records import (ATTACHMENT, ATTACHMENT_INDEX, CHANNEL, CHUNK, CHUNK_INDEX, DATA_END, FOOTER, HEADER, MAGIC, MESSAGE,
                           MESSAGE_INDEX, METADATA, METADATA_INDEX, SCHEMA, STATISTICS, Channel, Damage, Fields, Message, Missing,
                           Schema, check_filled, is_known)

_HEAD = struct.Struct("<BQ")  # opcode and length
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time and publish time [ns]
_LONGEST_RECORD = 256 << 20  # [bytes]
_LONGEST_CHUNK = 64 << 20  # [bytes] decompressed
_MOST_SEARCHED = 4  # bytes of damaged records that are read, in sizes of the file; a file that was only damaged needs 1
_FOOTER_SIZE = _HEAD.size + 20  # [bytes]
_DATA_END_SIZE = _HEAD.size + 4  # [bytes]
# After damage the search stops only at these records: a chunk has none of them. The upper byte of every possible length is zero.
_OUTSIDE_OF_CHUNKS = re.compile(rb"[\x06\x07\x09\x0c\x0f](?=.{7}\x00|.{0,7}\Z)", re.DOTALL)

Bytes = Union[bytes, mmap.mmap]


class TooLarge(Exception):
    """The chunks would decompress to more bytes than are allowed."""


@dataclass
class File:
    """The whole parts of an MCAP file. messages() fills the rest while it runs."""
    data: Bytes
    schemas: Dict[int, Schema] = field(default_factory=dict)
    channels: Dict[int, Channel] = field(default_factory=dict)
    metadata: List[Tuple[str, Dict[str, str]]] = field(default_factory=list)
    attachments: Dict[str, bytes] = field(default_factory=dict)
    missing: List[Missing] = field(default_factory=list)
    found: int = 0  # number of whole messages
    counted: Optional[int] = None  # number of messages by the file's statistics, if they are readable
    allowed: Optional[int] = None  # [bytes] to which all chunks may decompress; None: any number
    _times: Dict[int, Tuple[int, int]] = field(default_factory=dict)  # [ns] of the chunks of the summary, by their place
    _places: List[int] = field(default_factory=list)  # of these chunks, in order
    _summary: Optional[int] = None  # [bytes] where it begins
    _searched: int = 0  # [bytes] of damaged records that were read

    def messages(self) -> Iterator[List[Message]]:
        """The messages of each whole chunk, in the file's order. Raises TooLarge."""
        self._read_summary()
        self._places = sorted(self._times)
        size, at, ended = len(self.data), len(MAGIC), False
        whole: Set[int] = set()
        data_end = size if self._summary is None else self._summary
        if self.data[:at] != MAGIC:
            self._miss(0, min(at, size), "the first bytes are none of an MCAP file", False)
        while at < data_end:
            head = self._head(at)
            if head is None or not self._possible(at, *head):
                following = min(self._next_after(at + 1), data_end)
                to_the_end = following == size and self._summary is None
                self._miss(at, following, "the file ends within a record, or is damaged to its end" if to_the_end
                           else "no record begins here", False)
                at = following
                continue
            opcode, end = head
            if opcode == DATA_END:
                self._check_crc(at)
                at, ended = end, True
                break
            wrong, trusted, messages = "", True, []
            try:
                check_filled(opcode, memoryview(self.data)[at + _HEAD.size:end])
            except Damage:
                wrong, trusted = "the length of a record is damaged", False
            else:
                try:
                    if self._summary is None or opcode not in (SCHEMA, CHANNEL):  # else those of the summary count
                        messages = self._take(opcode, self.data[at + _HEAD.size:end])
                except Damage as error:
                    wrong = str(error)
                    self._searched += end - at
            if wrong and self._searched > _MOST_SEARCHED * size:
                self._miss(at, data_end, "records lie within damaged records too often: the search ends here", False)
                at = data_end
                continue
            if wrong:
                at = self._lost(at, opcode, end if trusted and end > at + _HEAD.size else None, wrong)
                continue
            if opcode == CHUNK:
                whole.add(at)
            at = end
            if messages:
                self.found += len(messages)
                yield messages
        self._judge_end(at, ended, whole)

    def _judge_end(self, at: int, ended: bool, whole: Set[int]) -> None:
        size = len(self.data)
        if self._summary is None and not ended and (not self.missing or self.missing[-1].end < size):
            self._miss(size, size, "the file ends before its footer: its last seconds may be missing", False)
        if self._summary is not None and not ended and not self.missing:
            self._miss(at, at, "the record that ends the data is damaged, but every chunk is whole", False)
        if self._summary is None and ended and not self._ends_without_summary(at):
            self._miss(at, size, "the summary is damaged; no message is in it", False)
        ends = [part.end for part in self.missing]  # the parts are in the file's order, and do not overlap
        parts = list(self.missing)
        for place in self._places:
            part = bisect.bisect_right(ends, place)
            if place not in whole and not (part < len(parts) and parts[part].begin <= place):
                self._miss(place, place, "a chunk of the summary is not there", False)

    def _ends_without_summary(self, at: int) -> bool:
        """Whether the footer of a file that never had a summary is here."""
        end = at + _FOOTER_SIZE
        return self.data[end:] == MAGIC and self.data[at:at + _HEAD.size + 8] == _HEAD.pack(FOOTER, 20) + bytes(8)

    def _head(self, at: int) -> Optional[Tuple[int, int]]:
        """Opcode and end of the record at a place; None: no record can begin there."""
        if len(self.data) - at < _HEAD.size:
            return None
        opcode, length = _HEAD.unpack(self.data[at:at + _HEAD.size])
        if not is_known(opcode) or length > min(_LONGEST_RECORD, len(self.data) - at - _HEAD.size):
            return None
        return opcode, at + _HEAD.size + length

    def _possible(self, at: int, opcode: int, end: int) -> bool:
        """Whether the data may have a record with this head. An index of the summary may be a chunk with a damaged opcode."""
        if end > (len(self.data) if self._summary is None else self._summary):
            return False
        if opcode in (FOOTER, CHUNK_INDEX, ATTACHMENT_INDEX, METADATA_INDEX, STATISTICS):
            return False
        if opcode == DATA_END:
            return end - at == _DATA_END_SIZE and self._summary in (None, end)
        if opcode == CHUNK:
            return True
        if opcode == MESSAGE:  # outside of chunks it has no CRC
            return self._summary is not None and not self._times
        return at not in self._times

    def _is_record(self, at: int) -> bool:
        """Whether a record begins here: its fields fill it, or another one follows, which may be cut."""
        size = len(self.data)
        if at == size:
            return True
        head = self._head(at)
        if head is None:
            return False
        opcode, end = head
        if opcode == DATA_END:
            return end - at == _DATA_END_SIZE
        if opcode in (HEADER, METADATA, SCHEMA, CHANNEL, MESSAGE_INDEX, ATTACHMENT, CHUNK):
            try:
                check_filled(opcode, memoryview(self.data)[at + _HEAD.size:end])
                return True
            except Damage:
                return False
        if size - end <= _HEAD.size or self._head(end):
            return True
        opcode, length = _HEAD.unpack(self.data[end:end + _HEAD.size])
        return is_known(opcode) and length <= _LONGEST_RECORD

    def _next_after(self, at: int) -> int:
        """The place of the next record that cannot be in a chunk."""
        for place in _OUTSIDE_OF_CHUNKS.finditer(self.data, at):
            if self._is_record(place.start()):
                return place.start()
        return len(self.data)

    def _lost(self, at: int, opcode: int, behind: Optional[int], what: str) -> int:
        """Notes a damaged record. behind: its end, or None if its length is wrong. Returns where to go on: behind it if another one is there."""
        end = len(self.data) if self._summary is None else self._summary
        goes_on = behind is not None and (behind == end or self._is_record(behind))
        following = behind if behind is not None and goes_on else min(self._next_after(at + 1), end)
        self._miss(at, following, what, opcode == CHUNK and behind is not None)
        return following

    def _miss(self, begin: int, end: int, what: str, is_chunk: bool) -> None:
        """Notes a missing part. is_chunk: the times of a chunk are at its begin."""
        first = bisect.bisect_left(self._places, begin)
        behind = max(bisect.bisect_left(self._places, end), bisect.bisect_right(self._places, begin))
        times = [self._times[place] for place in self._places[first:behind]]
        content = begin + _HEAD.size
        if is_chunk and begin not in self._times and content + 16 <= len(self.data):
            first_time, last_time = struct.unpack("<QQ", self.data[content:content + 16])
            if first_time <= last_time:
                times.append((first_time, last_time))
        span = (min(early for early, _ in times), max(late for _, late in times)) if times else None
        self.missing.append(Missing(begin, end, what, span))

    def _check_crc(self, data_end: int) -> None:
        """Bytes outside of all chunks may be damaged too."""
        said = int.from_bytes(self.data[data_end + _HEAD.size:data_end + _DATA_END_SIZE], "little")
        if said == 0 or self.missing:
            return
        crc = 0
        for at in range(0, data_end, 1 << 20):
            crc = zlib.crc32(self.data[at:min(at + (1 << 20), data_end)], crc)
        if crc != said:
            self._miss(data_end, data_end + _DATA_END_SIZE, "the CRC of the data is wrong, but every chunk is whole", False)

    def _read_summary(self) -> None:
        """The definitions, the times of the chunks and the statistics, if the summary is whole."""
        at = len(self.data) - len(MAGIC) - _FOOTER_SIZE
        if at < 0 or self.data[-len(MAGIC):] != MAGIC or self.data[at] != FOOTER:
            return
        footer = self.data[at:at + _FOOTER_SIZE]
        start, _, crc = struct.unpack("<QQI", footer[_HEAD.size:])
        if not 0 < start < at:
            return
        summary = self.data[start:at]
        if crc and crc != zlib.crc32(footer[:-4], zlib.crc32(summary)):
            return
        schemas: Dict[int, Schema] = {}
        channels: Dict[int, Channel] = {}
        rest = Fields(summary)
        try:
            while rest.at < len(summary):
                opcode = rest.number(1)
                record = rest.take(rest.number(8))
                fields = Fields(record)
                if opcode == SCHEMA:
                    number = fields.number(2)
                    schemas[number] = Schema(fields.text(), fields.text(), fields.blob())
                elif opcode == CHANNEL:
                    number = fields.number(2)
                    channels[number] = Channel(fields.number(2), fields.text(), fields.text(), fields.map())
                elif opcode == CHUNK_INDEX:
                    times = fields.number(8), fields.number(8)
                    self._times[fields.number(8)] = times
                elif opcode == STATISTICS:
                    self.counted = fields.number(8)
        except Damage:
            self._times.clear()
            return
        self.schemas, self.channels, self._summary = schemas, channels, start

    def _take(self, opcode: int, content: bytes) -> List[Message]:
        """Takes a record over. Returns the messages in it."""
        fields = Fields(content)
        if opcode == SCHEMA:
            number = fields.number(2)
            if number and self.schemas.setdefault(number, schema := Schema(fields.text(), fields.text(), fields.blob())) != schema:
                raise Damage("two schemas have the same number")
        elif opcode == CHANNEL:
            number = fields.number(2)
            channel = Channel(fields.number(2), fields.text(), fields.text(), fields.map())
            if channel.schema and channel.schema not in self.schemas:
                raise Damage("a channel has a schema that did not come before it")
            if self.channels.setdefault(number, channel) != channel:
                raise Damage("two channels have the same number")
        elif opcode == MESSAGE:
            return [self._message(content)]
        elif opcode == CHUNK:
            return self._chunk(fields)
        elif opcode == METADATA:
            self.metadata.append((fields.text(), fields.map()))
        elif opcode == ATTACHMENT:
            fields.take(16)
            name, _ = fields.text(), fields.blob()
            data = fields.take(fields.number(8))
            checked = fields.at
            crc = fields.number(4)
            if crc and crc != zlib.crc32(content[:checked]):
                raise Damage("the CRC of an attachment is wrong")
            self.attachments[name] = data
        return []

    def _message(self, content: bytes) -> Message:
        if len(content) < _MESSAGE.size:
            raise Damage("a message ends within a field")
        channel, _, log_time, _ = _MESSAGE.unpack_from(content)
        if channel not in self.channels:
            raise Damage("a message is of a channel that did not come before it")
        return Message(channel, log_time, content[_MESSAGE.size:])

    def _chunk(self, fields: Fields) -> List[Message]:
        fields.take(16)
        size, crc, compression = fields.number(8), fields.number(4), fields.text()
        records = fields.take(fields.number(8))
        if size > _LONGEST_CHUNK:
            raise Damage(f"a chunk says that it has {size} bytes, and at most {_LONGEST_CHUNK} are read")
        if self.allowed is not None:
            self.allowed -= size
            if self.allowed < 0:
                raise TooLarge
        if compression == "zstd":
            try:
                records = zstd.decompress(records, size)
            except ValueError:
                raise Damage("a chunk cannot be decompressed") from None
        elif compression:
            raise Damage("a chunk is compressed by a method that is not known here; convert the file with: mcap compress --compression zstd")
        if len(records) != size:
            raise Damage("a chunk has another size than it says")
        if crc and crc != zlib.crc32(records):
            raise Damage("the CRC of a chunk is wrong")
        found: List[Message] = []
        at = 0
        while at < size:
            if size - at < _HEAD.size:
                raise Damage("a record of this chunk is longer than the chunk")
            opcode, length = _HEAD.unpack_from(records, at)
            at += _HEAD.size
            if length > size - at:
                raise Damage("a record of this chunk is longer than the chunk")
            content = records[at:at + length]
            at += length
            if opcode == MESSAGE:
                found.append(self._message(content))
            elif opcode in (CHUNK, FOOTER, DATA_END):
                raise Damage("a chunk has a record that may not be in one")
            else:
                self._take(opcode, content)
        return found
