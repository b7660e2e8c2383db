"""The page on what a memory is worth: its places, its ladder, and its table."""

from __future__ import annotations

from stucksolver.ladder import parse_ladder, profile_text
from stucksolver_eval.result_pages import memory
from stucksolver_eval.suites import suite


def test_memory_page_routes_are_in_suite_and_distinct():
    """All routes are in the suite and distinct, and some remain as held-out routes."""
    names = list(memory.DESTINATIONS)
    known = {route.id for route in suite(memory.SUITE).routes}
    assert set(names) <= known
    assert 0 < memory.LESSONS < len(names) == len(set(names))


def test_memory_page_ladder_differs_only_in_solid_line():
    """The ladder differs from the default one only in the approval for a solid line."""
    ours, default = parse_ladder(memory._ladder(), "ours"), parse_ladder(profile_text("default"), "default")
    assert ours != default
    assert ours.model_copy(update={"approval": default.approval}) == default
    assert ours.approval.model_copy(update={"solid_line": default.approval.solid_line}) == default.approval


def test_a_row_counts_drives_questions_and_calls():
    drives = [memory.MemoryRunResult(True, 0, 0, 90.0), memory.MemoryRunResult(False, 2, 1, 20.0)]
    assert memory._row("lessons: 2", drives) == "| lessons: 2 | 1 of 2 | 2 | 1 | 55.0 |"


def test_memory_page_table_rows_match_header_columns():
    """Each row of the table has as many columns as its header."""
    page = memory.page([memory._row("before", [memory.MemoryRunResult(True, 0, 0, 100.0)])])
    table = [line for line in page.splitlines() if line.startswith("|")]
    assert len(table) == 3
    assert len({line.count("|") for line in table}) == 1
