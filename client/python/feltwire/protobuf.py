"""Decodes Protobuf messages into columns, by the schema that is in the recording (a FileDescriptorSet)."""
from __future__ import annotations

import operator
import struct
from array import array
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

Value = Any  # a number, a text, bytes, or a list or dict of these

DOUBLE, FLOAT, BOOL, STRING, MESSAGE, BYTES, ENUM = 1, 2, 8, 9, 11, 12, 14
_SIGNED = {3, 5, ENUM}  # varints that are two's complement
_ZIGZAG = {17, 18}
_FIXED = {DOUBLE: "<d", FLOAT: "<f", 6: "<Q", 7: "<I", 15: "<i", 16: "<q"}
_WIRE = {DOUBLE: 1, 6: 1, 16: 1, FLOAT: 5, 7: 5, 15: 5, STRING: 2, MESSAGE: 2, BYTES: 2}  # all others: varint
_UNSIGNED = {4, 6, 7, 13}
_MOST_DEPTH = 32
_MOST_LAYOUTS = 64  # that are tried for a length
_MOST_SLOTS = 4096  # fields of a message, with those of the messages in it: a small schema can name billions

Place = Tuple[int, str, int]  # of a number in a message [bytes], its format for struct, its slot
Layout = Callable[[bytes], Optional[Tuple[Value, ...]]]


class Field(NamedTuple):
    """A field of a message."""
    name: str
    number: int
    type: int
    repeated: bool
    optional: bool
    type_name: str


def _varint(data: bytes, at: int) -> Tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]  # IndexError: the message ends
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & 0xFFFFFFFFFFFFFFFF, at
        shift += 7
        if shift > 63:
            raise ValueError("a number is too long")


def _fields(data: bytes, at: int, end: int) -> Iterator[Tuple[int, int, Any, int]]:
    """(number, wire type, value, place of the value) of each field. A value of wire type 2 is (begin, end)."""
    while at < end:
        tag, at = _varint(data, at)
        number, wire = tag >> 3, tag & 7
        place = at
        value: Any
        if wire == 0:
            value, at = _varint(data, at)
        elif wire in (1, 5):
            at += 8 if wire == 1 else 4
            value = None
        elif wire == 2:
            size, place = _varint(data, at)
            at = place + size
            value = (place, at)
        else:
            raise ValueError("a field has an obsolete type")
        if at > end or number == 0:
            raise ValueError("a field is longer than its message")
        yield number, wire, value, place


class Types:
    """The messages and enums of a FileDescriptorSet."""

    def __init__(self, descriptor_set: bytes):
        self.messages: Dict[str, Dict[int, Field]] = {}
        self.enums: Dict[str, Dict[int, str]] = {}
        for number, _, span, _ in _fields(descriptor_set, 0, len(descriptor_set)):
            if number == 1:
                self._file(descriptor_set[slice(*span)])

    @staticmethod
    def _parts(data: bytes) -> Dict[int, List[Any]]:
        parts: Dict[int, List[Any]] = {}
        for number, wire, value, _ in _fields(data, 0, len(data)):
            parts.setdefault(number, []).append(data[slice(*value)] if wire == 2 else value)
        return parts

    def _file(self, data: bytes) -> None:
        parts = self._parts(data)
        package = parts.get(2, [b""])[0].decode()
        for message in parts.get(4, []):
            self._message(message, package)
        for enum in parts.get(5, []):
            self._enum(enum, package)

    def _message(self, data: bytes, scope: str) -> None:
        parts = self._parts(data)
        name = f"{scope}.{parts[1][0].decode()}".lstrip(".")
        fields = {}
        for one in map(self._parts, parts.get(2, [])):
            fields[one[3][0]] = Field(one[1][0].decode(), one[3][0], one[5][0], one.get(4, [1])[0] == 3, bool(one.get(17, [0])[0]),
                                      one.get(6, [b""])[0].decode().lstrip("."))
        self.messages[name] = fields
        for message in parts.get(3, []):
            self._message(message, name)
        for enum in parts.get(4, []):
            self._enum(enum, name)

    def _enum(self, data: bytes, scope: str) -> None:
        parts = self._parts(data)
        values = [self._parts(one) for one in parts.get(2, [])]
        self.enums[f"{scope}.{parts[1][0].decode()}".lstrip(".")] = {one.get(2, [0])[0]: one[1][0].decode() for one in values}

    def value(self, data: bytes, wire: int, value: Any, place: int, kind: int, type_name: str, depth: int = 0) -> Value:
        """A value of a field."""
        if wire in (1, 5):
            return struct.unpack_from(_FIXED[kind], data, place)[0]
        if wire == 2:
            if kind == MESSAGE:
                return self.record(data, value[0], value[1], type_name, depth + 1)
            taken = data[slice(*value)]
            return taken.decode(errors="replace") if kind == STRING else taken
        if kind == BOOL:
            return bool(value)
        if kind in _ZIGZAG:
            return (value >> 1) ^ -(value & 1)
        return value - (1 << 64) if kind in _SIGNED and value >> 63 else value

    def record(self, data: bytes, begin: int, end: int, name: str, depth: int = 0) -> Dict[str, Value]:
        """A whole message as a dict. Fields that are not there have their default."""
        if depth > _MOST_DEPTH:
            raise ValueError("a message is nested too deep")
        fields = self.messages[name]
        found: Dict[str, Value] = {f.name: [] if f.repeated else default(f) for f in fields.values()}
        for number, wire, value, place in _fields(data, begin, end):
            one = fields.get(number)
            if one is None:
                continue
            expected = _WIRE.get(one.type, 0)
            if one.repeated and wire == 2 and expected != 2:  # packed
                at, stop = value
                while at < stop:
                    if expected == 0:
                        raw, after = _varint(data, at)
                    else:
                        raw, after = None, at + (8 if expected == 1 else 4)
                    found[one.name].append(self.value(data, expected, raw, at, one.type, one.type_name))
                    at = after
            elif wire == expected:
                taken = self.value(data, wire, value, place, one.type, one.type_name, depth)
                if one.repeated:
                    found[one.name].append(taken)
                else:
                    found[one.name] = taken
        return found


def default(one: Field) -> Value:
    """The value of a field that is not in a message. An optional number is not a number, everything else as Protobuf has it."""
    if one.type in (DOUBLE, FLOAT):
        return float("nan") if one.optional else 0.0
    if one.optional or one.type == MESSAGE:
        return None
    return {STRING: "", BYTES: b"", BOOL: False}.get(one.type, 0)


class Column(NamedTuple):
    """A column of a table: a number a row, several (width), or any value (code is empty)."""
    name: str
    slot: int
    width: int
    code: str  # of array.array
    enum: Dict[int, str]


class Rows:
    """The messages of a topic, as columns. A message of the same shape as an earlier one is taken by one struct.unpack()."""

    def __init__(self, types: Types, name: str):
        self._types, self._name = types, name
        self.columns: List[Column] = []
        self._slots: List[Tuple[str, Value]] = []  # code and default
        self._paths: Dict[Tuple[int, ...], Optional[int]] = {}  # of field numbers, to a slot; None: a message to look into
        self._field_at: Dict[Tuple[int, ...], Field] = {}
        self._plan(name, (), "", (name,))
        self.data: List[Any] = [array(code) if code else [] for code, _ in self._slots]
        self._defaults = tuple(value for _, value in self._slots)
        self._layouts: Dict[int, List[Layout]] = {}

    def _slot(self, path: Tuple[int, ...], one: Field) -> int:
        if len(self._slots) >= _MOST_SLOTS:
            raise ValueError(f"its messages have more than {_MOST_SLOTS} fields")
        numeric = not one.repeated and one.type not in (STRING, BYTES, MESSAGE)
        code = ""
        if numeric and not (one.optional and one.type not in (DOUBLE, FLOAT)):
            code = "d" if one.type in (DOUBLE, FLOAT) else "Q" if one.type in _UNSIGNED else "q"
        self._slots.append((code, [] if one.repeated else default(one)))
        self._paths[path], self._field_at[path] = len(self._slots) - 1, one
        return len(self._slots) - 1

    def _plan(self, message: str, path: Tuple[int, ...], prefix: str, above: Tuple[str, ...]) -> None:
        for one in self._types.messages[message].values():
            here = path + (one.number,)
            name = prefix + one.name
            inside = self._types.messages.get(one.type_name) if one.type == MESSAGE and not one.repeated else None
            if inside is None or one.type_name in above:
                slot = self._slot(here, one)
                self.columns.append(Column(name, slot, 1, self._slots[slot][0], self._types.enums.get(one.type_name, {})))
                continue
            self._paths[here], self._field_at[here] = None, one
            numbers = {field.name: field for field in inside.values() if field.type == DOUBLE and not field.repeated}
            for order in ("xyz", "wxyz"):  # quaternions as everywhere in feltwire
                if len(inside) == len(order) and set(numbers) == set(order):
                    slots = [self._slot(here + (numbers[axis].number,), numbers[axis]) for axis in order]
                    self.columns.append(Column(name, slots[0], len(order), "d", {}))
                    break
            else:
                self._plan(one.type_name, here, name + ".", above + (one.type_name,))

    def extend(self, messages: List[bytes]) -> None:
        """Adds a row for each message. Raises ValueError, IndexError or KeyError for one that is not as its schema says."""
        rows = [self._row(message) for message in messages]
        for target, values in zip(self.data, zip(*rows)):
            target.extend(values)

    def _row(self, data: bytes) -> Tuple[Value, ...]:
        layouts = self._layouts.setdefault(len(data), [])
        for layout in layouts:
            row = layout(data)
            if row is not None:
                return row
        values = list(self._defaults)
        for slot, (code, value) in enumerate(self._slots):
            if not code and isinstance(value, list):
                values[slot] = []
        places: List[Place] = []
        fixed = self._read(data, 0, len(data), self._name, (), values, places)
        if fixed and len(layouts) < _MOST_LAYOUTS:
            layouts.append(self._layout(data, places))
        return tuple(values)

    def _read(self, data: bytes, begin: int, end: int, name: str, path: Tuple[int, ...], values: List[Value], places: List[Place]) -> bool:
        """Reads a message into `values`. Returns whether all its numbers have a fixed place, which are then in `places`."""
        fixed, lists = True, None
        for number, wire, value, place in _fields(data, begin, end):
            here = path + (number,)
            one = self._field_at.get(here)
            if one is None or (wire != _WIRE.get(one.type, 0) and not one.repeated):
                fixed = False  # of a newer schema
                continue
            slot = self._paths[here]
            if slot is None:
                fixed &= self._read(data, value[0], value[1], one.type_name, here, values, places)
            elif one.repeated:
                fixed = False
                lists = lists or self._types.record(data, begin, end, name, len(path))
                values[slot] = lists[one.name]
            else:
                values[slot] = self._types.value(data, wire, value, place, one.type, one.type_name, len(path))
                if wire in (1, 5):
                    places.append((place, _FIXED[one.type][1], slot))
                elif wire == 0 and data[place] < 0x80 and one.type not in _ZIGZAG and one.type != BOOL:
                    places.append((place, "B", slot))
                else:
                    fixed = False
        return fixed and len({slot for _, _, slot in places}) == len(places)

    def _layout(self, data: bytes, places: List[Place]) -> Layout:
        """A function that takes a message of this shape: the same bytes between the numbers."""
        code, at = "<", 0
        between: List[bytes] = []
        fixed: List[int] = []
        varints: List[int] = []
        numbers: Dict[int, int] = {}
        for place, kind, slot in sorted(places) + [(len(data), "", -1)]:
            if place > at:
                code += f"{place - at}s"
                fixed.append(len(between))
                between.append(data[at:place])
            if kind:
                code += kind
                numbers[slot] = len(between)
                if kind == "B":
                    varints.append(len(between))
                between.append(b"")
                at = place + struct.calcsize("<" + kind)
        unpack = struct.Struct(code).unpack
        expected = tuple(between[i] for i in fixed)
        count = len(between)
        slots = [numbers.get(slot, count + slot) for slot in range(len(self._defaults))]
        pick, look, defaults = _getter(slots), _getter(fixed), self._defaults

        def take(message: bytes) -> Optional[Tuple[Value, ...]]:
            parts = unpack(message)
            if look(parts) != expected or any(parts[i] > 0x7F for i in varints):
                return None
            return pick(parts + defaults)

        return take


def _getter(indices: List[int]) -> Callable[[Tuple[Any, ...]], Tuple[Any, ...]]:
    """As operator.itemgetter, which gives no tuple for fewer than two."""
    if len(indices) > 1:
        return operator.itemgetter(*indices)
    return lambda parts: tuple(parts[i] for i in indices)
