"""The counts of a campaign by class and by cause, and its contacts: all that is stored of a scene and of a campaign."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

Row = dict[str, Any]
NOT_EXCUSED = "not excused"


def of_scene(place: int, name: str, number: int, rows: list[Row], all_rows: bool) -> Row:
    """Return one line of the result file.

    `all_rows`: store every row, not only those with a contact or a crossed line.
    """
    counts: Counter[str] = Counter()
    ends: Counter[str] = Counter()
    for row in rows:
        counts["proposed"] += 1
        counts[f"{row['source']} proposed"] += 1
        counts["accepted"] += row["accepted"]
        counts[f"{row['source']} accepted"] += row["accepted"]
        if row.get("driven"):
            counts["driven"] += 1
            ends[row["end"]] += 1
        if "contact" in row:
            counts["excused" if row["excused"] else NOT_EXCUSED] += 1
        counts["lines or rails"] += bool(row.get("missed"))
    found = [row for row in rows if "contact" in row or row.get("missed")]
    driven_s = round(sum(row["t"] for row in rows if row.get("driven")), 2)
    scene = {"place": place, "scene": number, "class": name, "driven_s": driven_s, "counts": +counts, "ends": ends}
    return {**scene, ("rows" if all_rows else "found"): rows if all_rows else found}


class Summary:
    """Adds up scenes."""

    def __init__(self) -> None:
        self.scenes = 0
        self.driven_s = 0.0
        self.counts: Counter[str] = Counter()
        self.classes: dict[str, Counter[str]] = defaultdict(Counter)
        self.ends: Counter[str] = Counter()
        self.found: list[Row] = []

    def add(self, scene: Row) -> None:
        """Add a line of the result file."""
        self.scenes += 1
        self.driven_s += scene["driven_s"]
        self.counts.update(scene["counts"])
        self.classes[scene["class"]].update(scene["counts"])
        self.ends.update(scene["ends"])
        self.found += scene.get("found", ())

    def causes(self) -> dict[str, int]:
        """Return the number of contacts by excuse, most frequent first."""
        rows = Counter(row["excused"] or NOT_EXCUSED for row in self.found if "contact" in row)
        return dict(rows.most_common())

    def brief(self) -> str:
        """Return one line of progress."""
        get = self.counts
        return (
            f"{self.scenes} scenes, {get['driven']} plans driven, {get['excused'] + get[NOT_EXCUSED]} contacts, "
            f"{get[NOT_EXCUSED]} not excused, {get['lines or rails']} lines or rails passed"
        )

    def data(self) -> Row:
        """Return the complete summary for a JSON file."""
        contacts = [
            {key: value for key, value in row.items() if key not in ("accepted", "driven")} for row in self.found
        ]
        return {
            "scenes": self.scenes,
            "driven_s": round(self.driven_s),
            "counts": dict(self.counts),
            "causes": self.causes(),
            "classes": {name: dict(counts) for name, counts in self.classes.items()},
            "ends": dict(self.ends),
            "found": contacts,
        }
