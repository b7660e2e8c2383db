"""A ladder is one file; a bad one is refused with file, line and remedy."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver import StuckSolver
from stucksolver.commands import main
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.ladder import PROFILES, LadderError, Resume, find_ladder, parse_ladder, profile, profile_text
from stucksolver.ladder.rungs import KINDS
from stucksolver.ladder.toml_lines import line_of
from stucksolver.plan import WaitReason
from stucksolver.plan.behaviors import ApprovalLevel

DEFAULT = profile_text("default")


def line_with(text: str, part: str) -> int:
    return next(n for n, line in enumerate(text.splitlines(), 1) if part in line)


def test_the_default_climbs_from_waiting_to_remote_assistance():
    assert [rung.kind for rung in profile("default").rungs] == ["wait", "reasoner", "model", "passenger", "remote"]


def test_the_evaluation_profile_asks_nobody_for_a_solid_line():
    assert profile("default").guard_policy().solid_line == "passenger"
    assert profile("evaluation").guard_policy().solid_line == "autonomous"
    assert "passenger" not in [rung.kind for rung in profile("evaluation").rungs]


def test_profile_evaluation_alone_permits_emergency_scene_without_approval():
    """Only the evaluation profile passes an emergency scene through the oncoming lane without an approval."""
    assert profile("default").guard_policy().emergency_scene is ApprovalLevel.OPERATOR
    assert profile("evaluation").guard_policy().emergency_scene is ApprovalLevel.AUTONOMOUS
    assert profile("evaluation").guard_policy().authority is ApprovalLevel.OPERATOR


def test_profile_evaluation_last_rung_resumes_with_new_plan():
    """In the evaluation profile, a new plan ends even the stop of the last rung."""
    assert profile("evaluation").rungs[-1].resume is Resume.PLAN


@pytest.mark.parametrize("name", PROFILES)
def test_profile_text_fits_one_screen_and_limits_every_wait(name):
    """A profile fits on one screen (65 lines of 120 characters) and limits every legitimate wait."""
    ladder = profile(name)
    assert len(profile_text(name).splitlines()) <= 65
    assert max(map(len, profile_text(name).splitlines())) <= 120
    for reason in WaitReason:
        assert ladder.waits.patience(reason).longest_s > 0


def test_the_waits_of_the_design_are_those_of_the_default():
    limits = profile("default").waits.limits()
    assert (limits.light_s, limits.queue_moved_within_s) == (180.0, 60.0)
    assert (limits.unknown_vehicle_s, limits.hazard_or_parked_s) == (10.0, 3.0)


BAD = {
    "a value out of bounds": ("tries = 3", "tries = 0", "rung 3, tries: .*greater than or equal to 1"),
    "a key misspelt": ("tries = 3", "tires = 3", "rung 3, tires: unknown key; did you mean tries"),
    "a kind that does not exist": ('kind = "model"', 'kind = "modell"', "rung 3: kind must be one of wait, reasoner"),
    "a wait that does not exist": ("light           =", "ligth           =", "waits, reasons, ligth"),
    "a wait of no time": ("longest_s = 300.0", "longest_s = -1.0", "queue, longest_s: .*greater than 0"),
    "an unknown version": ("version = 1", "version = 2", "version: .*should be 1"),
    "a table that is no table": ("[asking]", "[asking", "invalid TOML"),
    "a person who does not exist": ('solid_line = "passenger"', 'solid_line = "dog"', "approval, solid_line"),
    "an unknown behaviour": (
        "[approval.behaviors]",
        '[approval.behaviors]\nfly = "operator"',
        "unknown behavior 'fly'",
    ),
    "an unknown table": ("[asking]", "[wrods]", "wrods: unknown key; did you mean words"),
}


@pytest.mark.parametrize(("old", "new", "told"), BAD.values(), ids=BAD)
def test_a_bad_ladder_is_refused_with_file_line_and_remedy(old, new, told, tmp_path):
    text = DEFAULT.replace(old, new, 1)
    assert text != DEFAULT
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LadderError, match=told) as refused:
        find_ladder(path)
    changed = new.split("\n")[0]
    at = int(str(refused.value).split("line ")[1].split(":")[0])
    assert str(path) in str(refused.value)
    assert 0 <= at - line_with(text, changed) <= 1 or "kind" in told


def test_the_order_of_rungs_is_checked():
    swapped = DEFAULT.replace('kind = "wait"', 'kind = "remote"', 1)
    with pytest.raises(LadderError, match="`remote` must be the last"):
        parse_ladder(swapped, "x.toml")
    only_wait = DEFAULT[: DEFAULT.index('[[rung]]\nkind = "reasoner"')]
    with pytest.raises(LadderError, match="add one of kind `reasoner`"):
        parse_ladder(only_wait, "x.toml")


def test_ladder_with_former_kind_is_read():
    """Before the search, the first reasoner's rung was called `rules`."""
    former = DEFAULT.replace('kind = "reasoner"', 'kind = "rules"')
    assert parse_ladder(former, "x.toml") == parse_ladder(DEFAULT, "x.toml")


def test_a_ladder_without_any_reasoner_that_is_there_is_refused():
    no_reasoner = DEFAULT.replace('kind = "reasoner"', 'kind = "model"', 1)
    text = no_reasoner[: no_reasoner.index('[[rung]]\nkind = "passenger"')]
    with pytest.raises(ValueError, match="give a reasoner named model"):
        StuckSolver(lambda surroundings: None, ladder=parse_ladder(text, "x.toml"))


def test_a_file_that_is_not_there_names_the_profiles(tmp_path):
    with pytest.raises(LadderError, match="use default, evaluation, or a file"):
        find_ladder(tmp_path / "none.toml")


def test_solver_ladder_from_file_profile_or_value_is_used(tmp_path):
    """A ladder can be a file, the name of a profile or a value. A guard laxer than it is rejected."""
    path = tmp_path / "mine.toml"
    path.write_text(DEFAULT.replace('solid_line = "passenger"', 'solid_line = "operator"'), encoding="utf-8")
    for given_, expected in ((path, "operator"), ("evaluation", "autonomous"), (profile("default"), "passenger")):
        assert StuckSolver(lambda surroundings: None, ladder=given_).guard.policy.solid_line == expected
    with pytest.raises(LadderError, match="less approval than ladder 'default' for: solid_line"):
        StuckSolver(lambda surroundings: None, guard=Guard(), ladder=path)
    stricter = Guard(GuardPolicy(solid_line="forbid"))
    assert StuckSolver(lambda surroundings: None, guard=stricter, ladder=path).guard is stricter


def test_solver_guard_laxer_than_default_ladder_is_rejected():
    """A user's guard must not require less than the default ladder; a stricter guard is used."""
    with pytest.raises(LadderError, match="less approval than ladder 'default' for: solid_line"):
        StuckSolver(lambda surroundings: None, guard=Guard(GuardPolicy(solid_line="autonomous")))
    stricter = Guard(GuardPolicy(solid_line="forbid"))
    assert StuckSolver(lambda surroundings: None, guard=stricter).guard is stricter


def test_ladder_command_prints_profile_and_checks_file(tmp_path, capsys):
    """The command prints a profile that parses to the same ladder, and names the wrong line of a file."""
    assert main(["ladder", "evaluation"]) == 0
    printed = capsys.readouterr().out
    assert parse_ladder(printed, "x.toml") == profile("evaluation")
    path = tmp_path / "mine.toml"
    path.write_text(printed.replace("tries = 10", "tries = 1001"), encoding="utf-8")
    assert main(["ladder", str(path)]) == 2
    assert f"{path}, line {line_with(path.read_text(encoding='utf-8'), 'tries = 1001')}" in capsys.readouterr().err


def test_every_kind_of_rung_tells_what_it_does():
    for name, kind in KINDS.items():
        assert kind.model_fields["kind"].default == name
        assert kind.summary


@given(st.sampled_from([n for n, line in enumerate(DEFAULT.splitlines(), 1) if " = " in line and "{" not in line]))
def test_the_line_of_every_value_is_found(number):
    """Each key of the default is looked up by its own path."""
    where: list[int | str] = []
    rungs = -1
    for line in DEFAULT.splitlines()[:number]:
        name = line.split("#")[0].strip()
        if name.startswith("[["):
            rungs += 1
            where = ["rung", rungs]
        elif name.startswith("["):
            where = list(name.strip("[]").split("."))
    key = DEFAULT.splitlines()[number - 1].split("=")[0].strip()
    assert line_of(DEFAULT, [*where, key]) == number
