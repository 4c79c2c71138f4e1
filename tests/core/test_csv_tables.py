# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that we write run nothing in a spreadsheet, and come back."""

import csv
import io

import pytest
from hypothesis import given, strategies as st

from w2w.core.csv_tables import CsvError, apart, csv_text, read_table

CELLS = st.text("=+-@\t\r\n \"',1e.aＡ\u2028\x00＝＋", min_size=1)


@pytest.mark.parametrize(
    "cell", ["=cmd|'/c calc'!A1", "+cmd", "-2+3", "@SUM(1)", "\t=1", "\n=1", " =1", "＝1"]
)
def test_formulas_are_defused(cell):
    ((written, number),) = csv.reader(io.StringIO(csv_text([[cell, 1]]), newline=""))
    assert (written, number) == (f"'{cell}", "1")


@given(st.lists(st.sampled_from(["mean", "Mean", "mean (activity)", "walk"]), unique=True))
def test_activities_are_told_from_other_columns_and_from_each_other(activities):
    headings = apart(activities, ["patch", "mean"])
    assert len({"patch", "mean", *headings}) == 2 + len(activities)
    assert [name for name in activities if name == "walk"] == [name for name in headings if name == "walk"]


def test_no_line_end_begins_a_row():
    assert csv_text([["a\r=1", "b\r\n=2"]]) == '"a\n=1","b\n=2"\n'


@pytest.mark.parametrize(
    "cell", ["-0.123", "+1", "-1e-05", "walking", "a=b", -0.5, "", "left wrist - dorsal"]
)
def test_numbers_and_other_text_stay(cell):
    assert csv_text([[cell, "x"]]).rstrip("\n").removesuffix(",x") == str(cell)


@given(st.lists(st.tuples(CELLS, CELLS), max_size=5))
def test_no_cell_ever_begins_a_formula(rows):
    for row in csv.reader(io.StringIO(csv_text(rows), newline="")):
        for cell in row:
            starts = cell.lstrip()[:1] in set("=+-@") or cell[:1] in set("\t\r\n")
            assert not starts or float(cell) is not None


def test_a_table_comes_back(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(csv_text([["Region", "cost"], ["left wrist, dorsal", 2], [" ", ""]]))
    assert read_table(path, ("region", "cost")).rows == [(2, {"region": "left wrist, dorsal", "cost": "2"})]


LONG = "x" * (csv.field_size_limit() + 1)


@pytest.mark.parametrize(
    ("text", "line"),
    [(f"region,{LONG}\nhead,1\n", 1), (f"sep=,\n{LONG}\n", 2), (f"region\nhead\n{LONG}\n", 3)],
)
def test_a_cell_longer_than_any_is_named_with_its_line(tmp_path, text, line):
    (tmp_path / "table.csv").write_text(text)
    with pytest.raises(CsvError, match=rf"table\.csv, line {line}, cannot be read as csv: field larger"):
        read_table(tmp_path / "table.csv", ("region",))


def test_blanks_are_gone_over_once(tmp_path):
    """Each of a hundred thousand was looked at as the first of those before a line end."""
    blank = " " * 100_000
    (tmp_path / "table.csv").write_text(f'region\n"é{blank}x \r\n\t y"\n', encoding="utf-8")
    ((_, row),) = read_table(tmp_path / "table.csv", ("region",)).rows
    assert row["region"].startswith("é ")
    assert row["region"].endswith(" x y")
