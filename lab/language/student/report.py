"""Prints the scores of a student as text, and draws the calibration of its probabilities."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

GROUPS = {
    "train": "trained on",
    "tune": "same types and maps, other drives",
    "types": "held-out scenario types",
    "maps": "held-out maps",
    "routes": "held-out routes",
}


def report(groups: Mapping[str, Mapping[str, Any]]) -> str:
    """Return all scores as text: one block for each group of samples."""
    return "\n\n".join("\n".join(_block(name, found)) for name, found in groups.items())


def _block(name: str, found: Mapping[str, Any]) -> list[str]:
    lines = [f"{GROUPS.get(name, name)}: {found['moments']} moments of {found['standstills']} standstills"]
    lines.append("  wait ends within | share | Brier, of the share alone | right: student, rules wait")
    for until, item in found["wait"].items():
        if item["moments"]:
            lines.append(
                f"  {until:>4} s           | {item['share']:.2f}  | {item['brier']:.3f}, {item['brier_of_share']:.3f} "
                f"             | {item['accuracy']:.1%}, {item['accuracy_rules']:.1%}"
            )
    lines += _calibration(found["wait"].get("10", {}))
    cause, plans, words = found["cause"], found["plans"], found["words"]
    if cause["moments"]:
        lines.append(
            f"  cause right ({cause['moments']} moments): {cause['student']:.1%}, the network alone "
            f"{cause['network']:.1%}, rules {cause['rules']:.1%}"
        )
    if plans["moments"]:
        lines.append(
            f"  plans ({plans['moments']} moments with an accepted one): the first accepted {plans['first']:.1%}, "
            f"one of eight {plans['within']:.1%}, one of the rules' kind {plans['rules_accepted']:.1%}"
        )
    lines += [_choice(name, item) for name, item in found.get("choices", {}).items() if item["moments"]]
    if words["moments"]:
        lines.append(
            f"  plan of the rules' kind after a request ({words['moments']}): {words['right']:.1%}, "
            f"by chance {words['by_chance']:.1%}"
        )
    return lines


def _choice(name: str, item: Mapping[str, Any]) -> str:
    patient, idle = ("–" if item[key] is None else f"{item[key]:.1%}" for key in ("patient", "idle"))
    return (
        f"  {name}: waits at {item['waits']:.1%} of {item['moments']} moments, plans worth {item['worth']:.1f} m; "
        f"waits where the driver goes on within 10 s {patient}, where it does not within 40 s {idle}"
    )


def _calibration(wait: Mapping[str, Any]) -> list[str]:
    bins = wait.get("calibration", [])
    if not bins:
        return []
    rows = [f"    {b['said']:.2f} said, {b['true']:.2f} true, {b['moments']} moments" for b in bins]
    return ["  calibration, within 10 s:", *rows]


def draw_calibration(groups: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """Draw predicted against true probabilities of the wait ending, a panel for each group. It requires matplotlib."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4 * len(groups), 3.4), layout="constrained")
    for number, (name, found) in enumerate(groups.items(), 1):
        axes = figure.add_subplot(1, len(groups), number)
        axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
        for until, item in found["wait"].items():
            bins = item.get("calibration", [])
            axes.plot([b["said"] for b in bins], [b["true"] for b in bins], marker="o", label=f"within {until} s")
        axes.set_title(GROUPS.get(name, name), fontsize=9)
        axes.set(xlabel="said", ylabel="true", xlim=(0, 1), ylim=(0, 1))
    figure.axes[0].legend(fontsize=7)
    figure.savefig(path, metadata={"Date": None})
