"""The published pages say what the kept data says: each is made of it again."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stucksolver_eval.result_pages import RESULTS, bench2drive, guard_oracle, real_carla, result_tables

SAFETY = Path(__file__).resolve().parents[2] / "docs" / "SAFETY.md"


def page(name):
    return (RESULTS / f"{name}.md").read_text(encoding="utf-8")


def rows_with_figures(text):
    return [line for line in text.splitlines() if line.startswith("|") and re.search(r"\d", line)]


def test_the_oracle_s_page_is_made_of_what_is_kept():
    assert guard_oracle.page() == page("guard_oracle")


def test_bench2drive_s_page_is_made_of_what_is_kept():
    assert bench2drive.page(bench2drive.stored_runs()) == page("bench2drive")


@pytest.mark.integration
@pytest.mark.parametrize(
    "told",
    [
        ("bench220",),
        ("dev",),
        ("dev", "dev-now"),
        ("immobilized",),
        ("immobilized", "immobilized-now"),
        ("immobilized-now",),
        ("wrong",),
    ],
    ids=" ".join,
)
def test_each_row_of_the_tables_stands_in_its_page(told):
    rows = rows_with_figures("".join(result_tables.tables_of(*told)))
    assert rows and set(rows) <= set(page(told[0]).splitlines())


TABLE = "| arm | DS | SR % |\n|---|---|---|\n| rules | 80.0 | 70.0 |\n"


def test_result_table_replaces_one_with_same_first_headings():
    """A table replaces the one with the same first three column headings."""
    other = "| arm | DS | vs. alone |\n|---|---|---|\n| rules | 1 | 2 |\n"
    older = "| arm | DS | SR % | more |\n|---|---|---|---|\n| alone | 1 | 2 | 3 |\n| rules | 1 | 2 | 3 |\n"
    before = f"# Page\n\n{other}\n{older}\nText.\n"
    assert result_tables.replaced(before, TABLE) == f"# Page\n\n{other}\n{TABLE}\nText.\n"


@pytest.mark.parametrize("count", [0, 2])
def test_a_page_without_exactly_one_such_table_is_refused(count):
    with pytest.raises(result_tables.ResultPageError, match=f"{count} tables begin with | arm | DS | SR % |"):
        result_tables.replaced("Text.\n\n" + f"{TABLE}\n" * count, TABLE)


def test_carla_comparison_rows_are_in_result_page():
    """Each row of the comparison with CARLA is in its page of results."""
    rows = rows_with_figures(real_carla.table(real_carla.load(RESULTS / "real_carla.json")))
    assert rows and set(rows) <= set(page("real_carla").splitlines())


def test_guard_campaign_result_is_stored_and_matches_safety_case():
    """The last long campaign is stored, and the safety case gives the number of its contacts without an excuse.

    At most one contact in 5,000 plans counts against the guard.
    """
    campaigns = list(guard_oracle.campaigns().values())
    long = [k for k, data in enumerate(campaigns) if data["counts"]["driven"] >= guard_oracle.WANTED]
    assert bool(long) is (guard_oracle.NONE_YET not in page("guard_oracle"))
    numbers = {"None": 0, "One": 1, "Two": 2, "Three": 3, "Four": 4}
    says = re.search(r"\*\*(\w+) (?:is|are) not excused\*\*", SAFETY.read_text(encoding="utf-8"))
    against = [sum(bool(item.get("missed") or not item.get("excused")) for item in data["found"]) for data in campaigns]
    assert says is not None and numbers[says[1]] == against[long[-1]]
    for data, count in zip(campaigns[long[-1] :], against[long[-1] :], strict=True):
        assert 5000 * count <= data["counts"]["driven"]


def test_campaigns_count_each_contact_they_keep():
    for data in guard_oracle.campaigns().values():
        contacts = [item for item in data["found"] if "contact" in item]
        assert sum(data["causes"].values()) == len(contacts)
        assert data["counts"].get("not excused", 0) == sum(not contact["excused"] for contact in contacts)
        assert sum(counts.get("driven", 0) for counts in data["classes"].values()) == data["counts"]["driven"]
