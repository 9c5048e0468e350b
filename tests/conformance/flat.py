"""Writes and reads FlatBuffers by a schema (schema.py), made from the public description of the format.

Values are dicts for tables, dicts or tuples for structs, lists for vectors, (name, dict) for unions. What is read comes as `Value`,
a dict whose keys are attributes too; a field that is absent is None, or its default if it is a scalar.
"""
import struct

MOST_DEPTH = 32


class Malformed(Exception):
    """These bytes are no buffer of that table."""


class Value(dict):
    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


class Writer:
    """Appends objects, each behind those that point to it, so that all offsets go forwards."""

    def __init__(self, schema):
        self.schema, self.out = schema, bytearray()

    def pad(self, align):
        self.out += bytes(-len(self.out) % align)

    def inline(self, field, value):
        """The bytes of a scalar, a struct or an array."""
        if field.kind == "scalar":
            return struct.pack("<" + field.code, value)
        if field.kind == "array":
            return b"".join(self.inline(field.item, item) for item in value)
        one = self.schema.structs[field.type_name]
        parts = bytearray(one.size)
        for index, part in enumerate(one.fields):
            given = value.get(part.name) if isinstance(value, dict) else value[index]
            if given is not None:
                data = self.inline(part, given)
                parts[part.offset:part.offset + len(data)] = data
        return bytes(parts)

    def point(self, place):
        """Lets the offset at `place` point to the end of what is written."""
        struct.pack_into("<I", self.out, place, len(self.out) - place)

    def table(self, name, value, place):
        """Writes a table; `place`: where the offset to it stands."""
        table, inline, later = self.schema.tables[name], [], []
        unknown = set(value) - {field.name for field in table.fields}
        if unknown:
            raise KeyError(f"{name} has no {unknown}")
        for field in table.fields:
            given, slot = value.get(field.name), table.slots[field.name]
            if given is None:
                continue
            if field.kind in ("scalar", "struct"):
                inline.append((slot, *self.schema.size_of(field), self.inline(field, given)))
            elif field.kind == "union":
                number = self.schema.unions[field.type_name].values.get(given[0], given[0])
                inline += [(slot, 1, 1, bytes([number])), (slot + 1, 4, 4, bytes(4))]
                later.append((slot + 1, field, given))
            else:
                inline.append((slot, 4, 4, bytes(4)))
                later.append((slot, field, given))
        inline.sort(key=lambda entry: -entry[2])
        slots = 1 + max((entry[0] for entry in inline), default=-1)
        align = max([4] + [entry[2] for entry in inline])
        while (len(self.out) + 4 + 2 * slots) % align:
            self.out += b"\0"
        vtable = len(self.out)
        self.out += bytes(4 + 2 * slots)
        start = len(self.out)
        struct.pack_into("<I", self.out, place, start - place)
        self.out += struct.pack("<i", start - vtable)
        places = {}
        for slot, _, align, data in inline:
            self.pad(align)
            places[slot] = len(self.out)
            struct.pack_into("<H", self.out, vtable + 4 + 2 * slot, len(self.out) - start)
            self.out += data
        struct.pack_into("<HH", self.out, vtable, 4 + 2 * slots, len(self.out) - start)
        for slot, field, given in later:
            self.child(field, given, places[slot])

    def child(self, field, value, place):
        """Writes what an offset at `place` points to."""
        if field.kind == "table":
            self.table(field.type_name, value, place)
        elif field.kind == "union":
            self.table(value[0], value[1], place)
        elif field.kind == "string":
            data = value if isinstance(value, bytes) else value.encode()
            self.pad(4)
            self.point(place)
            self.out += struct.pack("<I", len(data)) + data + b"\0"
        else:
            self.vector(field.item, value, place)

    def vector(self, item, values, place):
        size, align = self.schema.size_of(item)
        while (len(self.out) + 4) % max(align, 4):
            self.out += b"\0"
        self.point(place)
        self.out += struct.pack("<I", len(values))
        if item.kind in ("scalar", "struct"):
            for value in values:
                self.out += self.inline(item, value)
            return
        first = len(self.out)
        self.out += bytes(4 * len(values))
        for index, value in enumerate(values):
            self.child(item, value, first + 4 * index)


def write(schema, table, value):
    """A whole buffer, without file identifier and size prefix."""
    writer = Writer(schema)
    writer.out += bytes(4)
    writer.table(table, value, 0)
    writer.pad(4)
    return bytes(writer.out)


class Reader:
    """Reads with a check of every place and alignment."""

    def __init__(self, schema, data):
        self.schema, self.data = schema, bytes(data)

    def get(self, code, place):
        size = struct.calcsize("<" + code)
        if place < 0 or place + size > len(self.data) or place % size:
            raise Malformed(f"{code} at {place} of {len(self.data)}")
        return struct.unpack_from("<" + code, self.data, place)[0]

    def jump(self, place):
        offset = self.get("I", place)
        if offset == 0:
            raise Malformed("an offset of zero")
        return place + offset

    def inline(self, field, place):
        if field.kind == "scalar":
            return self.get(field.code, place)
        if field.kind == "array":
            size, _ = self.schema.size_of(field.item)
            return [self.inline(field.item, place + index * size) for index in range(field.length)]
        one = self.schema.structs[field.type_name]
        if place % one.align:
            raise Malformed(f"{one.name} at {place}")
        return Value({part.name: self.inline(part, place + part.offset) for part in one.fields})

    def table(self, name, start, depth=0):
        if depth > MOST_DEPTH:
            raise Malformed("too deep")
        table = self.schema.tables[name]
        vtable = start - self.get("i", start)
        size, length = self.get("H", vtable), self.get("H", vtable + 2)
        if size < 4 or size % 2 or vtable + size > len(self.data) or start + length > len(self.data):
            raise Malformed(f"the vtable of {name}")

        def place(slot):
            if 4 + 2 * slot + 2 > size:
                return None
            offset = self.get("H", vtable + 4 + 2 * slot)
            return start + offset if offset else None

        value = Value()
        for field in table.fields:
            at = place(table.slots[field.name])
            if field.kind == "union":
                kind = self.get("B", at) if at else 0
                other = place(table.slots[field.name] + 1)
                value[field.name] = self.union(field, kind, other, depth) if kind and other else None
            elif at is None:
                value[field.name] = field.default if field.kind == "scalar" else None
            elif field.kind in ("scalar", "struct"):
                value[field.name] = self.inline(field, at)
            else:
                value[field.name] = self.child(field, self.jump(at), depth)
            if field.required and value[field.name] is None:
                raise Malformed(f"{name} has no {field.name}")
        return value

    def union(self, field, kind, place, depth):
        names = {number: key for key, number in self.schema.unions[field.type_name].values.items()}
        if kind not in names:
            raise Malformed(f"{field.type_name} {kind} is unknown")
        return names[kind], self.table(names[kind], self.jump(place), depth + 1)

    def child(self, field, place, depth):
        if field.kind == "table":
            return self.table(field.type_name, place, depth + 1)
        count = self.get("I", place)
        place += 4
        if field.kind == "string":
            if place + count + 1 > len(self.data) or self.data[place + count]:
                raise Malformed("the end of a string")
            return self.data[place:place + count].decode("utf-8", "replace")
        size, _ = self.schema.size_of(field.item)
        if place + count * size > len(self.data):
            raise Malformed(f"{count} items of {size} bytes")
        if field.item.kind in ("scalar", "struct"):
            return [self.inline(field.item, place + index * size) for index in range(count)]
        return [self.child(field.item, self.jump(place + 4 * index), depth) for index in range(count)]


def read(schema, table, data):
    """The root table of a buffer; raises Malformed."""
    reader = Reader(schema, data)
    return reader.table(table, reader.jump(0))
