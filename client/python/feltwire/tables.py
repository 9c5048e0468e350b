"""Tables: columns by name, as NumPy arrays or, without NumPy, as lists and arrays of the standard library."""
from __future__ import annotations

import csv
import io
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

from .errors import FileError

# Columns of the CSV files that are a vector together, and its name. The first that a file has whole counts.
VECTORS: Tuple[Tuple[str, Tuple[str, ...]], ...] = (
    ("position", ("x", "y", "z")), ("elastic", ("ex", "ey", "ez")), ("frictional", ("fx", "fy", "fz")), ("held", ("rx", "ry", "rz")),
    ("orientation", ("qw", "qx", "qy", "qz")), ("torque", ("tx", "ty", "tz")), ("held_elastic", ("rex", "rey", "rez")),
    ("held_frictional", ("rfx", "rfy", "rfz")))


def numpy_or_none() -> Any:
    """The module numpy, or None where it is not installed."""
    try:
        import numpy
    except ImportError:
        return None
    return numpy


class Table:
    """The messages of a topic, or the rows of a CSV file. table["held"] is the column `held`, one row a message.

    topic: its name. fields: the names of the columns. rows: their number. times [s]: of each row, since the first message of the
    recording. log_time [ns]: since 1970, where the file has it. enums: for a column of enum numbers the name of each number.
    """

    def __init__(self, topic: str, columns: Mapping[str, Any], times: Any, log_time: Any = None,
                 enums: Optional[Dict[str, Dict[int, str]]] = None):
        self.topic = topic
        self._columns = dict(columns)
        self.times, self.log_time = times, log_time
        self.enums = enums or {}
        self.rows = len(times) if times is not None else max((len(one) for one in self._columns.values()), default=0)

    @property
    def fields(self) -> List[str]:
        """The names of the columns."""
        return list(self._columns)

    def __getitem__(self, field: str) -> Any:
        if field not in self._columns:
            raise KeyError(f"{self.topic} has no field {field}; it has {', '.join(self._columns)}")
        return self._columns[field]

    def __contains__(self, field: object) -> bool:
        return field in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return self.rows

    def names(self, field: str) -> List[str]:
        """A column of enum numbers as names: table.names("no_force")."""
        known = self.enums[field]
        return [known.get(int(number), str(int(number))) for number in self[field]]

    def __repr__(self) -> str:
        return f"<{self.topic}: {self.rows} rows of {', '.join(self._columns)}>"


def vectors(columns: Dict[str, Any]) -> Dict[str, Any]:
    """Columns x, y, z as one column `position`, and so on."""
    numpy = numpy_or_none()
    found: Dict[str, Any] = {}
    part_of: Dict[str, str] = {}
    for name, axes in VECTORS:
        if all(axis in columns for axis in axes):
            part_of.update(dict.fromkeys(axes, name))
    for column, values in columns.items():
        whole = part_of.get(column)
        if whole is None:
            found[{"t": "time"}.get(column, column)] = values
        elif whole not in found:
            parts = [columns[axis] for axis in dict(VECTORS)[whole]]
            found[whole] = numpy.column_stack(parts) if numpy else list(zip(*parts))
    return found


def from_csv(text: Iterable[str], name: str) -> Dict[str, Any]:
    """The columns of CSV lines with a header: numbers where a column has only numbers, else texts. Raises FileError for a line with
    another number of fields. A last line that is cut (no end of line, fewer fields) is left out."""
    numpy = numpy_or_none()
    lines = list(text)
    reader = csv.reader(lines)
    head: List[str] = next(reader, [])
    rows: List[List[str]] = []
    while True:
        try:
            row = next(reader)
        except StopIteration:
            break
        except csv.Error as error:
            raise FileError(f"{name}:{reader.line_num}: {error}; give a CSV file of numbers with a header") from None
        if not row:
            continue
        if len(row) != len(head):
            if reader.line_num == len(lines) and not lines[-1].endswith("\n"):
                break
            raise FileError(f"{name}:{reader.line_num}: {len(row)} fields, and the header has {len(head)}; give a CSV file with a header")
        rows.append(row)
    columns: Dict[str, Any] = {}
    for i, title in enumerate(head):
        texts = [row[i] for row in rows]
        try:
            whole = all(one.lstrip("-").isdigit() for one in texts) and title.endswith("_ns")
            values: Any = [int(one) for one in texts] if whole else [float(one) for one in texts]
            columns[title] = numpy.array(values) if numpy else values
        except ValueError:
            columns[title] = texts
    return columns


def to_csv(table: Any) -> str:
    """CSV lines with a header of a mapping of columns, a NumPy array with fields, or a list of dicts."""
    head: List[str]
    rows: Iterable[Any]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    if isinstance(table, (list, tuple)):
        head = list(table[0]) if table else []
        rows = ([row[name] for name in head] for row in table)
    elif getattr(getattr(table, "dtype", None), "names", None):
        head, rows = list(table.dtype.names), table.tolist()
    else:
        head = list(table)
        columns = [column.tolist() if hasattr(column, "tolist") else list(column) for column in (table[name] for name in head)]
        if len({len(column) for column in columns}) > 1:
            raise ValueError("the columns of the table have different lengths")
        rows = zip(*columns)
    if not head:
        raise ValueError("the table has no columns; give at least one row, or a dict of columns")
    writer.writerow(head)
    for row in rows:
        writer.writerow([repr(float(one)) if isinstance(one, float) else one for one in row])
    return out.getvalue()
