"""The mutation runner lists the changes that it promises, and each leaves a source that compiles."""

from __future__ import annotations

import pytest

from lab.benchmarks.mutation.mutants import mutants_of, reads
from lab.benchmarks.mutation.page import MEANINGS, page
from lab.benchmarks.mutation.results import KILLED, SURVIVED, Result, line_of, read
from lab.benchmarks.mutation.run import all_mutants, sources

CASES = {
    "x = a < b": {"x = a <= b", "x = a >= b"},
    "x = a is not None": {"x = a is None"},
    "x = a not in b": {"x = a in b"},
    "x = not a and b": {"x = not a or b", "x = True and b", "x = not a and True", "x = (a) and b"},
    "x = c if a else b": {"x = c if not (a) else b"},
    "x = a**2 - b": {"x = a*2 - b", "x = a**3 - b", "x = a**2 + b"},
    "x = min(abs(a), b)": {"x = max(abs(a), b)", "x = min((a), b)"},
    "return a, b": {"return b, a"},
    "x += a": {"None", "x -= a"},
    "call(a)": {"None"},
    "x = f'{a + 1}'": set(),
    "turn.tell('a', b + 1)": set(),
    "return Reject(detail=a + 1)": set(),
}


def changes(source: str) -> set[str]:
    raw = source.encode()
    return {mutant.applied(raw).decode() for mutant in mutants_of(raw)}


@pytest.mark.parametrize("code", CASES, ids=list(CASES))
def test_mutants_of_a_statement_are_its_operators_and_bounds(code: str) -> None:
    head = "def it(a, b, c, x, turn):\n    "
    assert changes(head + code + "\n") == {f"{head}{case}\n" for case in CASES[code]}


def test_mutants_of_an_early_return_never_take_it() -> None:
    source = "def it(a):\n    if a:\n        return 1\n    return 2\n"
    heads = {change.split("\n")[1].strip() for change in changes(source)}
    assert {"if False:", "if not (a):"} < heads


def test_mutants_of_a_named_bound_make_it_larger_and_smaller() -> None:
    source = b"FAR_M: float = 4.0\nKINDS = frozenset({A, B})\nMOST = 6\n"
    found = mutants_of(source)
    assert {item.name for item in found} == {"FAR_M", "KINDS", "MOST"} and all(item.imports for item in found)
    assert {item.new for item in found} == {"(4.0) * 1.25", "(4.0) * 0.8", "{B}", "{A}", "5", "7"}


def test_mutants_of_the_guard_compile_and_keep_their_lines() -> None:
    files = sources()
    for name, mutant in all_mutants(files)[::40]:
        source = files[name]
        changed = mutant.applied(source)
        compile(changed, name, "exec", dont_inherit=True)
        assert changed.count(b"\n") == source.count(b"\n")
        assert mutant.kind in MEANINGS


def test_readers_of_a_bound_are_the_statements_that_use_it() -> None:
    source = b"import a\n\n\ndef it(x):\n    if x < a.FAR_M:\n        return 1\n    y = (\n        FAR_M\n    )\n"
    assert {lines for name, lines in reads(source) if name == "FAR_M"} == {(5, 5), (7, 9)}


def test_results_survive_a_kill_and_make_the_page(tmp_path) -> None:
    """A line that was cut off is left out; of two results of a mutant the later one counts."""
    first = Result("guard/rss.py", 3, "boundary", "a < b -> a <= b", SURVIVED, "", 7, 7, 0.5)
    later = Result("guard/rss.py", 3, "boundary", "a < b -> a <= b", KILLED, "test_rss.py::test_it", 1, 8, 0.1)
    other = Result("guard/rss.py", 9, "sign", "-a -> (a)", SURVIVED, "", 7, 9, 0.5)
    path = tmp_path / "mutants.tsv"
    path.write_text("".join(map(line_of, (first, other, later))) + "guard/rss.py\t10\tsi", encoding="utf-8")
    found = read(path)
    assert set(found) == {later, other}
    text = page(found, 3, 0)
    assert "| `guard/rss.py` | 2 | 1 | 0 | 0 | 1 |" in text and "1 of 3 mutants" in text
