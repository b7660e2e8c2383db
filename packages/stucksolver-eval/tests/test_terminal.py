"""Tables for a terminal fit its width, and lose no figure on the way."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.commands.terminal_text import filled
from stucksolver_eval.terminal_table import table

HEAD = ("Run", "Score", "Success %", "By rung", "Notes")
NAMES = st.text("abcdefgh +:/", min_size=1, max_size=50).map(str.strip).filter(bool)
CELLS = st.sampled_from(["1.00", "99.5", "rules 12, passenger 3", "–", "7 (8)"])
ROWS = st.lists(st.tuples(NAMES, CELLS, CELLS, CELLS, CELLS), min_size=1, max_size=9)


@given(ROWS, st.integers(60, 120))
def test_no_line_is_wider_than_the_terminal(rows, width):
    assert max(map(len, table(HEAD, rows, width).splitlines()), default=0) <= width


@pytest.mark.integration
@given(ROWS, st.integers(60, 120))
def test_every_name_and_every_figure_is_told(rows, width):
    text = table(HEAD, rows, width)
    if not text:
        assert all(cell == "–" for row in rows for cell in row[1:])
        return
    for name, *cells in rows:
        assert name in text
        assert all(text.count(cell) >= 1 for cell in cells if cell != "–")
    for cell in ("1.00", "99.5", "7 (8)"):
        assert len(re.findall(rf"(?<!\S){re.escape(cell)}(?!\S)", text)) >= sum(row.count(cell) for row in rows)


def test_what_fits_has_a_row_for_each_run():
    lines = table(HEAD, [("alone", "1", "2", "3", "4"), ("rules", "5", "6", "7", "8")], 80).splitlines()
    assert [line.split()[0] for line in lines[2:]] == ["alone", "rules"]


def test_table_turned_shows_part_of_run_in_brackets():
    """In a table that is turned for width, a part of a run follows its value in brackets."""
    wide = "driver + something with a very long name indeed"
    text = table(HEAD, [(wide, "80.1", "50", "–", "–"), ("  corrected", "70.2", "", "", "")], 60)
    assert re.search(r"Score +80\.1 \(corrected 70\.2\)", text)
    assert "By rung" not in text, "nobody has a figure for it"


@given(st.text(" abc,.", max_size=300), st.integers(20, 100))
def test_paragraphs_are_filled(text, width):
    assert all(len(line) <= width or " " not in line.strip() for line in filled(text, width).splitlines())
