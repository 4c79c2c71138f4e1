# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables as csv text: read from spreadsheets of any country, written so that no cell runs as a formula."""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from .wording import clean, harmless, restated

SEPARATORS = ",;\t|"

BYTE_ORDER_MARKS = (
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)
WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""First bytes of xlsx, ods and xls files."""

FORMULA = re.compile(r"[\t\r\n]|\s*[=+\-@＝＋－＠]")
"""Beginnings of cells that Excel, LibreOffice or Sheets take for formulas."""


BREAKS = re.compile(r"[\t\r\n]+")
"""Line ends within a cell of a spreadsheet."""


class CsvError(ValueError):
    """A csv file cannot be understood; the message says which file and what to change."""

    def __init__(self, message: str) -> None:
        super().__init__(harmless(message))


class CsvTable(NamedTuple):
    """Rows of a csv file."""

    rows: list[tuple[int, dict[str, str]]]
    """The line a row ends on and its cells by column, without surrounding spaces, as they can be shown."""
    note: str
    """The assumptions that were needed to read it, if any."""


def read_table(path: str | Path, required: Sequence[str], optional: Sequence[str] = ()) -> CsvTable:
    """Read named columns of a csv file.

    The separator is the one of `SEPARATORS` by which the first line holds the required columns. Their names
    are given in lower case, and case does not count; an optional column that is missing reads as empty. Text
    is UTF-8, UTF-16 or UTF-32, else Windows-1252. Raises CsvError, with the reason, if a file cannot be read.
    """
    text, note = decoded(Path(path))
    names = (*required, *optional)
    lines = io.StringIO(text, newline="")
    first = int(bool(re.match(r'"?sep=.', text, re.IGNORECASE)))  # Excel's own note on the separator
    if first:
        lines.readline()
    start = lines.tell()
    header = lines.readline()
    with restated(f"{clean(path)}, line {first + 1}, cannot be read as csv:", csv.Error, CsvError):
        separator = max(SEPARATORS, key=lambda mark: len(set(required) & set(_columns(header, mark))))
        columns = _columns(header, separator)
    if not set(required) <= set(columns):
        wanted = " and ".join(f"'{name}'" for name in required)
        raise CsvError(
            f"{clean(path)} needs the columns {wanted} in its first line, and has: "
            f"{', '.join(filter(None, columns)) or 'nothing'} "
            "(columns may be separated by commas, semicolons, tabs or bars)"
        )
    if twice := [name for name in names if columns.count(name) > 1]:
        raise CsvError(f"{clean(path)} has the column '{twice[0]}' {columns.count(twice[0])} times: keep one")
    lines.seek(start)
    reader = csv.reader(lines, delimiter=separator, strict=True)
    rows = []
    try:
        next(reader)
        for cells in reader:
            row = dict(zip(columns, map(_label, cells), strict=False))
            if any(row.values()):
                rows.append((first + reader.line_num, {name: row.get(name, "") for name in names}))
    except csv.Error as error:
        line = f"{clean(path)}, line {first + reader.line_num}"
        raise CsvError(f"{line}, cannot be read as csv: {error}") from error
    return CsvTable(rows, note)


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Rows as csv text; an apostrophe precedes text that a spreadsheet would run as a formula."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows([_harmless(cell) for cell in row] for row in rows)
    return stream.getvalue()


def apart(names: Sequence[str], others: Iterable[str]) -> list[str]:
    """Names of activities as headings next to others: those that are taken get a further word.

    Examples
    --------
    >>> apart(["walking", "mean"], ["patch", "mean"])
    ['walking', 'mean (activity)']
    """
    taken = {name.casefold() for name in others}
    headings = []
    for name in names:
        heading = name
        while heading.casefold() in taken or (heading != name and heading in names):
            heading += " (activity)"
        headings.append(heading)
    return headings


def _harmless(cell: object) -> object:
    if not isinstance(cell, str):
        return cell
    cell = cell.replace("\r\n", "\n").replace("\r", "\n")  # csv quotes no bare \r: it would begin a row
    if not FORMULA.match(cell):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def decoded(path: Path) -> tuple[str, str]:
    """The text of a file, and the assumptions needed to read it; CsvError if it is no text."""
    with restated(lambda error: f"{clean(path)} cannot be read: {error.strerror}", OSError, CsvError):
        data = path.read_bytes()
    if data.startswith(WORKBOOKS):
        raise CsvError(f"{clean(path)} is a spreadsheet's workbook, not a csv file: save it as CSV (UTF-8)")
    with restated(f"{clean(path)} is no text: save it as CSV (UTF-8)", UnicodeDecodeError, CsvError):
        for mark, encoding in BYTE_ORDER_MARKS:
            if data.startswith(mark):
                return data.decode(encoding), ""
        if b"\0" in data[:200]:
            return data.decode("utf-16-be" if data[:1] == b"\0" else "utf-16-le"), ""
    try:
        return data.decode("utf-8"), ""
    except UnicodeDecodeError:
        note = f"{clean(path.name)} is not UTF-8 text and was read as Windows-1252 (Western European)"
        return data.decode("cp1252", errors="replace"), f"{note}: save it as UTF-8 if letters look wrong"


def _label(cell: str) -> str:
    text = cell.strip()
    return text if text.isascii() and text.isprintable() else clean(_one_line(text))


def _one_line(text: str) -> str:
    """A cell's text with a space in place of line ends and what is blank around them."""
    return " ".join(filter(None, map(str.strip, BREAKS.split(text))))


def _columns(header: str, separator: str) -> list[str]:
    cells = next(csv.reader([header], delimiter=separator), [])
    return [cell.strip().lower() for cell in cells]
