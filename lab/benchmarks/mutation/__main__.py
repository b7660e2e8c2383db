"""Mutation testing of the guard and of the execution of plans.

```
python3.12 -m lab.benchmarks.mutation run --out OUT
python3.12 -m lab.benchmarks.mutation page OUT/mutants.tsv
```

The first command changes one operator, bound, condition or early return at a time, and runs the tests that reach it
until one fails; tests marked `slow` are left out. A second run with the same folder continues at the stop of the first
one. The second command writes `results/mutation.md` and `results/mutation/mutants.tsv`. Both require only the core's
packages, pytest and hypothesis.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="lab.benchmarks.mutation", description=(__doc__ or "").split("\n", 1)[0])
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="run mutants")
    run.add_argument("--out", type=Path, required=True, help="folder of the results; mutants in it are not run again")
    run.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)), help="mutants at the same time")
    run.add_argument("--limit-s", type=float, default=20.0, help="CPU time of the tests of one mutant (default: 20)")
    run.add_argument("--for-s", type=float, default=float("inf"), help="begin no mutant after this time")
    run.add_argument("--sample", type=int, default=0, help="maximum number of mutants, drawn at random")
    run.add_argument("--again", action="store_true", help="run survivors once more, after tests were added")
    run.add_argument(
        "--file", action="append", default=[], help="only this file, as guard/path_checks.py; may be repeated"
    )
    run.add_argument(
        "--tests",
        nargs="+",
        default=["packages/stucksolver/tests"],
        help="where the tests are (default: packages/stucksolver/tests)",
    )
    listed = commands.add_parser("list", help="list the mutants")
    listed.add_argument("--file", action="append", default=[])
    page = commands.add_parser("page", help="write the page of results")
    page.add_argument("results", type=Path)
    options = parser.parse_args()
    if options.command == "page":
        from lab.benchmarks.mutation.page import write_page

        write_page(options.results)
        return
    if not hasattr(sys, "monitoring"):
        raise SystemExit(
            "error: unsupported Python version. Use Python 3.12: its monitoring finds cheaply which tests reach a line"
        )
    from lab.benchmarks.mutation.session import prepare

    prepare()
    from lab.benchmarks.mutation.run import Options, Run, all_mutants, sources

    if options.command == "list":
        files = sources(options.file)
        for name, mutant in all_mutants(files):
            print(f"{name}:{mutant.line}\t{mutant.kind}\t{mutant.change(files[name])}")
        return
    wanted = Options(
        options.out.resolve(),
        options.processes,
        options.limit_s,
        options.for_s,
        options.sample,
        options.again,
        tuple(options.file),
        tuple(options.tests),
    )
    Run(wanted).run()


if __name__ == "__main__":
    main()
