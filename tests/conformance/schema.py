"""Reads the schemas of the protocol (protocol/wire/*.fbs): what FlatBuffers calls structs, tables, enums and unions."""
import math
import re
import struct
from pathlib import Path

WIRE = Path(__file__).resolve().parents[2] / "protocol/wire"
SCALARS = {"bool": "?", "byte": "b", "ubyte": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "long": "q", "ulong": "Q",
           "float": "f", "double": "d"}


class Field:
    """A field of a struct or a table. `kind` is scalar, struct, array, string, table, union or vector."""

    def __init__(self, name, type_name, default, required, length):
        self.name, self.type_name, self.default, self.required, self.length = name, type_name, default, required, length
        self.kind = None
        self.item = None  # the field that describes an item of a vector or an array


class Struct:
    """Fixed layout: the fields with their offsets, the size and the alignment in bytes."""

    def __init__(self, name, fields):
        self.name, self.fields, self.size, self.align = name, fields, 0, 1


class Table:
    """Fields by slot. A union takes two slots: its type, then its value."""

    def __init__(self, name, fields):
        self.name, self.fields = name, fields
        self.slots = {}


class Enum:
    def __init__(self, name, base, values):
        self.name, self.base, self.values = name, base, values  # values: name -> number


class Schema:
    """All declarations of one file."""

    def __init__(self, text):
        self.text = text
        text = re.sub(r"//[^\n]*", "", text)
        self.structs, self.tables, self.enums, self.unions = {}, {}, {}, {}
        for word, name, base, body in re.findall(r"\b(struct|table|enum|union)\s+(\w+)\s*(?::\s*(\w+)\s*)?\{([^}]*)\}", text):
            if word in ("enum", "union"):
                self._add_enum(word, name, base, body)
            else:
                fields = [self._field(line) for line in body.split(";") if line.strip()]
                (self.structs if word == "struct" else self.tables)[name] = (Struct if word == "struct" else Table)(name, fields)
        for owner in [*self.structs.values(), *self.tables.values()]:
            for field in owner.fields:
                self._resolve(field)
        for one in self.structs.values():
            self._lay_out(one)
        for table in self.tables.values():
            slot = 0
            for field in table.fields:
                table.slots[field.name] = slot
                slot += 2 if field.kind == "union" else 1

    def _add_enum(self, word, name, base, body):
        values, number = {}, 1 if word == "union" else 0
        for part in body.split(","):
            if not part.strip():
                continue
            key, _, value = (piece.strip() for piece in part.partition("="))
            number = int(value) if value else number
            values[key] = number
            number += 1
        (self.unions if word == "union" else self.enums)[name] = Enum(name, base or "ubyte", values)

    @staticmethod
    def _field(line):
        match = re.match(r"\s*(\w+)\s*:\s*(\[\s*(\w+)\s*(?::\s*(\d+)\s*)?\]|\w+)\s*(?:=\s*([\w.+-]+))?\s*(\(required\))?\s*$", line)
        if not match:
            raise ValueError(f"not a field: {line!r}")
        name, whole, item, length, default, required = match.groups()
        field = Field(name, whole if item is None else item, default, bool(required), int(length) if length else None)
        field.kind = None if item is None else ("array" if length else "vector")
        return field

    def _resolve(self, field):
        if field.kind in ("vector", "array"):
            field.item = Field(field.name, field.type_name, None, False, None)
            self._resolve(field.item)
            return
        name = field.type_name
        if name in SCALARS or name in self.enums:
            field.kind = "scalar"
            field.code = SCALARS[name if name in SCALARS else self.enums[name].base]
            field.default = self._default(field)
        elif name in self.structs:
            field.kind = "struct"
        elif name == "string":
            field.kind = "string"
        elif name in self.unions:
            field.kind = "union"
        else:
            field.kind = "table"

    def _default(self, field):
        text = field.default
        if text is None:
            return False if field.code == "?" else 0
        if field.type_name in self.enums:
            return self.enums[field.type_name].values[text]
        if field.code == "?":
            return text == "true"
        return math.nan if text == "nan" else (float(text) if field.code in "fd" else int(text))

    def _lay_out(self, one):
        if one.size:
            return
        offset = 0
        for field in one.fields:
            size, align = self.size_of(field)
            offset += -offset % align
            field.offset = offset
            offset += size
            one.align = max(one.align, align)
        one.size = offset + -offset % one.align

    def size_of(self, field):
        """(size, alignment) in bytes of a value that stands inline."""
        if field.kind == "scalar":
            size = struct.calcsize("<" + field.code)
            return size, size
        if field.kind == "array":
            size, align = self.size_of(field.item)
            return size * field.length, align
        if field.kind == "struct":
            one = self.structs[field.type_name]
            self._lay_out(one)
            return one.size, one.align
        return 4, 4  # an offset


DATAGRAM = Schema((WIRE / "datagram.fbs").read_text(encoding="utf-8"))
CONTROL = Schema((WIRE / "control.fbs").read_text(encoding="utf-8"))
