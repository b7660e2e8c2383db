"""Writes results/guided.md: the benefit and the cost of guidance, by kind of help.

```sh
python -m stucksolver_eval.result_pages.guided bench220=OUT/search,OUT/guided immobilized=OUT2/rules,OUT2/guided
```

Both folders of a pair contain the same routes with the same seeds, driven with `--recovery search`; the second with
`--guidance shipped`. The rows omit routes without guidance, which are the same in both.
"""

from __future__ import annotations

import sys
from pathlib import Path

from stucksolver_eval.metrics.guidance_effect import GuidanceEffect, help_figures
from stucksolver_eval.metrics.paired_statistics import Difference
from stucksolver_eval.metrics.summary import Summary, summarize
from stucksolver_eval.result_pages import RESULTS
from stucksolver_eval.results.store import ResultStore

TITLE = "# What guidance gains, and what it costs"
ABOUT = """Routes and words were drawn by seed and scenario type (`python -m stucksolver_eval.guidance.assignment`), and
committed before anything was driven with them. Each row is the paired difference, guided minus unguided, on the routes
on which that was said; brackets are 95 % intervals of a bootstrap over routes. `won` and `lost` are drives that succeed
in one arm only. `harm` is the number of additional infractions and near misses in all drives together. Bold rows sum up
one kind. Both arms were driven with `--recovery search`, ladder `evaluation`, simulator carlette, commit d20f4eb, and
only on the routes with words (`--routes` with the ids in `suites/data/guidance-SUITE.json`).

The goal was 5 points of driving score and 10 of success rate. `immobilized` reaches it on the routes with words,
because of the broken red light; over all its 125 routes the gain is 2.7 and 4.0 points, which misses the goal.
`bench220` and `dev` miss it on any count: the routes that they fail lack sight of the oncoming lane or a gap in
traffic, and words cannot replace either. Words that are dangerous, wrong or unhelpful changed no score. On the four
routes with a rock there is no other street to the destination."""
HEAD = "| kind | what was said | drives | DS | SR, points | won | lost | harm |\n|---|---|---|---|---|---|---|---|"


class GuidedPageError(ValueError):
    """The arguments are wrong. The message contains the correct form."""


def pairs_of(arguments: list[str]) -> dict[str, tuple[Path, Path]]:
    """Parse the pairs of folders, by suite name. Raises `GuidedPageError`."""
    found = {}
    for argument in arguments:
        name, _, folders = argument.partition("=")
        both = folders.split(",")
        if not name or len(both) != 2 or not all(both):
            raise GuidedPageError(f"not a pair: {argument!r}. Write SUITE=UNGUIDED,GUIDED")
        found[name] = (Path(both[0]), Path(both[1]))
    if not found:
        raise GuidedPageError("give at least one pair: SUITE=UNGUIDED,GUIDED")
    return found


def page(pairs: dict[str, tuple[Path, Path]]) -> str:
    """Return the page. Raises `StoreError` if a folder contains no evaluation."""
    parts = [TITLE, "", ABOUT]
    for name, folders in pairs.items():
        unguided, guided = (summarize(ResultStore(folder)) for folder in folders)
        parts += ["", f"## {name}", "", _whole(unguided, guided), "", HEAD]
        parts += [_row(figure) for figure in help_figures(unguided, guided)]
    return "\n".join(parts) + "\n"


def _whole(unguided: Summary, guided: Summary) -> str:
    seeds = ", ".join(map(str, guided.manifest.seeds))
    scores = [f"{item.driving_score:.1f} / {item.success_rate:.1f}" for item in (unguided, guided)]
    return (
        f"{len(guided.rows)} drives, seeds {seeds}. Driving score / success rate over all drives: "
        f"{scores[0]} unguided, {scores[1]} guided."
    )


def _row(effect: GuidanceEffect) -> str:
    mark = "" if effect.help else "**"
    cells = [
        effect.kind,
        effect.help or "all",
        str(effect.drives),
        _difference_text(effect.score),
        _difference_text(effect.success),
    ]
    return "| " + " | ".join(f"{mark}{cell}{mark}" for cell in [*cells, effect.won, effect.lost, effect.harm]) + " |"


def _difference_text(paired: Difference) -> str:
    it = paired.difference
    mean, low, high = (round(value, 1) + 0.0 for value in (it.mean, it.low, it.high))
    return f"{mean:+.1f} [{low:+.1f}, {high:+.1f}]"


def main(arguments: list[str]) -> int:
    """Write the page. Returns 2 if the arguments are wrong, else 0."""
    try:
        pairs = pairs_of(arguments)
    except GuidedPageError as error:
        # The message is for the command line; the exit code reports the failure.
        print(f"error: {error}", file=sys.stderr)
        return 2
    (RESULTS / "guided.md").write_text(page(pairs), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
