"""Writes results/guided.md: what a person's words gained and cost, by the sort of help.

    python -m stucksolver_eval.pages.guided bench220=OUT/rules,OUT/guided immobilized=OUT2/rules,OUT2/guided

Each pair of folders holds the same routes with the same seeds, driven with `--recovery rules`, the second with
`--guidance shipped`. Routes on which nothing was said are left out of the rows; they are the same in both arms.
"""

from __future__ import annotations

import sys
from pathlib import Path

from stucksolver_eval.pages import RESULTS
from stucksolver_eval.results.store import Store
from stucksolver_eval.scores.by_help import HelpFigures, help_figures
from stucksolver_eval.scores.statistics import Difference
from stucksolver_eval.scores.summary import Summary, summarize

TITLE = "# What a person's words gain, and what they cost"
ABOUT = """Routes and words were drawn by seed and scenario type (`python -m stucksolver_eval.guidance.draw`), and
committed before anything was driven with them. Each row is guided less unguided on the routes on which that was
said, paired; brackets hold 95 % of a bootstrap over routes. `won` and `lost` are drives that are a success in one
arm only; `harm` is infractions and near misses more, of all drives together. Bold rows have all sorts of one kind.
Driven with `--recovery rules`, ladder `evaluation`, simulator carlette, commit 5d065b7, on the routes with words
alone (`--routes` with the ids in `suites/data/guidance-SUITE.json`), both arms with that commit. The aim was 5 points
of driving score and 10 of success. `immobilized` reaches it on these routes, through the red light that is
broken; over all of its 125 routes that is 2.7 and 4.0 points. `bench220` does not: what its failed routes lack is
sight of the oncoming lane or a gap in a stream, which no words replace. The four routes with a rock have no other
street to their destination."""
HEAD = "| kind | what was said | drives | DS | SR, points | won | lost | harm |\n|---|---|---|---|---|---|---|---|"


class UsageError(ValueError):
    """The arguments are not what they should be; the message says how they look."""


def pairs_of(arguments: list[str]) -> dict[str, tuple[Path, Path]]:
    """Folders by name of the suite. Raises `UsageError`."""
    found = {}
    for one in arguments:
        name, _, folders = one.partition("=")
        both = folders.split(",")
        if not name or len(both) != 2 or not all(both):
            raise UsageError(f"{one!r} is not a pair; write SUITE=UNGUIDED,GUIDED")
        found[name] = (Path(both[0]), Path(both[1]))
    if not found:
        raise UsageError("name at least one pair: SUITE=UNGUIDED,GUIDED")
    return found


def page(pairs: dict[str, tuple[Path, Path]]) -> str:
    """The page's text. Raises `StoreError` for a folder that holds no evaluation."""
    parts = [TITLE, "", ABOUT]
    for name, folders in pairs.items():
        unguided, guided = (summarize(Store(folder)) for folder in folders)
        parts += ["", f"## {name}", "", _whole(unguided, guided), "", HEAD]
        parts += [_row(one) for one in help_figures(unguided, guided)]
    return "\n".join(parts) + "\n"


def _whole(unguided: Summary, guided: Summary) -> str:
    seeds = ", ".join(map(str, guided.manifest.seeds))
    scores = [f"{one.driving_score:.1f} / {one.success_rate:.1f}" for one in (unguided, guided)]
    return (
        f"{len(guided.rows)} drives, seed {seeds}. Driving score / success rate over all of them: "
        f"{scores[0]} unguided, {scores[1]} guided."
    )


def _row(one: HelpFigures) -> str:
    mark = "" if one.help else "**"
    cells = [one.kind, one.help or "all", str(one.drives), _told(one.score), _told(one.success)]
    return "| " + " | ".join(f"{mark}{cell}{mark}" for cell in [*cells, one.won, one.lost, one.harm]) + " |"


def _told(paired: Difference) -> str:
    it = paired.difference
    mean, low, high = (round(value, 1) + 0.0 for value in (it.mean, it.low, it.high))
    return f"{mean:+.1f} [{low:+.1f}, {high:+.1f}]"


def main(arguments: list[str]) -> int:
    """Writes the page; 2 where the arguments are wrong."""
    try:
        pairs = pairs_of(arguments)
    except UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    (RESULTS / "guided.md").write_text(page(pairs), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
