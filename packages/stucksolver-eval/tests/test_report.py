"""The report is one file that opens anywhere, shows every run, and cannot be taken over by what runs say."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
import subprocess
import sys
from html.parser import HTMLParser
from importlib.resources import files
from itertools import accumulate
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver_eval.report import ReportError, write_report
from stucksolver_eval.report.page import SCRIPTS, embedded_json
from stucksolver_eval.report.run_log_packing import pack, series
from stucksolver_eval.results.checkpoint import COMPLETED, PERFECT
from stucksolver_eval.results.run_log import (
    ActorInfo,
    DecisionMoment,
    LaneArea,
    LogEvent,
    MapView,
    Marking,
    RunLog,
    RunLogFrame,
    RunResult,
)

ASSETS = files("stucksolver_eval.report") / "assets"
HOSTILE = "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)> & {{DATA}} \u2028"
STREET = MapView(
    name="street",
    lanes=(LaneArea(kind="driving", left=((0, 3.5), (200, 3.5)), right=((0, 0), (200, 0))),),
    markings=(Marking(points=((0, 3.5), (200, 3.5)), kind="broken", color="yellow"),),
)
DECISION = {
    "version": 1,
    "observation": {"controls": [], "participants": [], "summary": "a van"},
    "analysis": {"steps": [], "immobilized": True, "cause": "parked_vehicle", "reason": "it is parked"},
    "plan": {"behaviors": [{"name": "borrow_oncoming_lane", "length_m": 31.0}]},
    "rationale": "the other lane is free",
}


def run_log(scenario="parked car", arm="StuckSolver", words="go round it", frames=(), actors=1, **changes):
    """A small run; `words` stand wherever text that is not ours can stand."""
    return RunLog(
        **{
            "scenario": scenario,
            "arm": arm,
            "seed": 7,
            "driver": "rules",
            "reasoner": words,
            "clock": "lockstep",
            "perception": "ground truth",
            "map": STREET,
            "route": ((0, 1.75), (200, 1.75)),
            "actors": tuple(
                ActorInfo(label=words, kind="car", length_m=4.5, width_m=1.9, role="ego" if not n else "traffic")
                for n in range(actors)
            ),
            "frames": tuple(frames),
            "stuck": ((3.0, 9.5),),
            "decisions": (
                DecisionMoment(
                    time_s=5.0,
                    trigger="guidance",
                    decision={**DECISION, "rationale": words},
                    outcome="accepted",
                    verdict="accepted",
                ),
            ),
            "events": (LogEvent(time_s=4.0, kind="guidance", text=words),),
            "result": RunResult(
                status="Completed",
                route_completion_pct=100,
                infractions={words: 1},
                stopped_s=6.5,
                time_to_recover_s=8.0,
                immobilizations=1,
                decisions=1,
                plans_accepted=1,
                duration_s=30,
                distance_m=200,
            ),
            **changes,
        }
    )


class Page(HTMLParser):
    """The elements of a page with their text."""

    def __init__(self, text):
        super().__init__()
        self.elements: list[tuple[str, dict, list[str]]] = []
        self.inside = False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs), []))
        self.inside = True

    def handle_endtag(self, tag):
        self.inside = False

    def handle_data(self, data):
        if self.inside:
            self.elements[-1][2].append(data)

    def texts(self, tag):
        return ["".join(text) for name, _, text in self.elements if name == tag]

    def data(self):
        return json.loads(next("".join(t) for _, a, t in self.elements if a.get("id") == "data"))


def written(tmp_path, runs, title="Runs", notes=()):
    path = tmp_path / "report.html"
    write_report(runs, path, title, notes)
    return path.read_text(encoding="utf-8")


# --- what it shows ---


def test_every_run_title_and_note_is_in_the_page(tmp_path):
    arms = ["driver alone", "StuckSolver", "StuckSolver + passenger"]
    page = Page(written(tmp_path, [run_log(arm=arm) for arm in arms], "A title", ["a note", "another"]))
    data = page.data()
    assert [run["arm"] for run in data["runs"]] == arms
    assert data["title"] == "A title" and page.texts("title") == ["A title"]
    assert data["notes"] == ["a note", "another"]
    for run in data["runs"]:
        assert run["decisions"][0]["decision"] == {**DECISION, "rationale": "go round it"}
        assert run["result"]["time_to_recover_s"] == 8.0
        assert run["stuck"] == [[3.0, 9.5]]


def test_a_report_without_runs_is_written(tmp_path):
    assert Page(written(tmp_path, [])).data()["runs"] == []


def test_a_map_shared_by_runs_is_stored_once():
    other = run_log(map=STREET.model_copy(update={"name": "elsewhere"}))
    packed = pack([run_log(), run_log(arm="driver alone"), other], "", [])
    assert [run["map"] for run in packed["runs"]] == [0, 0, 1]
    assert [view["name"] for view in packed["maps"]] == ["street", "elsewhere"]


# --- self-contained and not to be taken over ---


def test_the_page_fetches_nothing(tmp_path):
    text = written(tmp_path, [run_log()])
    assert not re.search(r"(?i)\b(src|href|action)\s*=\s*[\"']?\s*(https?:)?//", text)
    assert not re.search(r"(?i)@import|url\(|fetch\(|XMLHttpRequest|import\(", text)
    assert set(re.findall(r"https?://[^\"' ]+", text)) == {"http://www.w3.org/2000/svg"}


def test_hostile_words_stay_words(tmp_path):
    run = run_log(scenario=HOSTILE, arm=HOSTILE, words=HOSTILE)
    text = written(tmp_path, [run], HOSTILE, [HOSTILE])
    page = Page(text)
    assert [tag for tag, _, _ in page.elements].count("script") == 2
    assert not page.texts("img")
    assert page.texts("title") == [HOSTILE]
    data = page.data()
    assert data["notes"] == [HOSTILE]
    assert data["runs"][0]["events"][0]["text"] == HOSTILE
    assert data["runs"][0]["decisions"][0]["decision"]["rationale"] == HOSTILE
    assert "alert(2)>" not in text


def test_half_a_character_in_the_title_does_no_harm(tmp_path):
    assert Page(written(tmp_path, [], "cut \ud83d off")).texts("title") == ["cut \ufffd off"]


@pytest.mark.integration
@given(st.recursive(st.text() | st.integers() | st.none(), lambda x: st.lists(x) | st.dictionaries(st.text(), x)))
def test_embedded_data_cannot_begin_markup_and_reads_back(value):
    text = embedded_json(value)
    assert text.isascii() and not set("<>&") & set(text)
    assert json.loads(text) == value


def test_the_policy_permits_exactly_the_two_inline_blocks(tmp_path):
    page = Page(written(tmp_path, [run_log()]))
    policy = next(a["content"] for _, a, _ in page.elements if a.get("http-equiv"))
    assert policy.startswith("default-src 'none';")
    for block in (page.texts("style")[0], page.texts("script")[1]):
        digest = base64.b64encode(hashlib.sha256(block.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert "unsafe" not in policy


def test_scripts_put_text_on_the_page_as_text_only():
    names = {asset.name for asset in ASSETS.iterdir() if asset.name.endswith(".js")}
    assert names == set(SCRIPTS)
    for name in names:
        text = (ASSETS / name).read_text(encoding="utf-8")
        assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function", text)


# --- written whole or not at all ---


def test_folders_are_made_and_nothing_else_is_left(tmp_path):
    path = tmp_path / "out" / "demo" / "report.html"
    write_report([run_log()], path, "Runs", [])
    assert [entry.name for entry in path.parent.iterdir()] == ["report.html"]


@pytest.mark.integration
def test_report_failed_write_names_remedy_and_keeps_old_report(tmp_path):
    """A failed write names the path and the remedy, and keeps the old report."""
    path = tmp_path / "report.html"
    path.write_text("the old report", encoding="utf-8")
    code = f"""
import resource, signal, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_report import run_log
from stucksolver_eval.report import ReportError, write_report
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
try:
    write_report([run_log()], {str(path)!r}, "Runs", [])
except ReportError as error:
    print(error)
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert f"cannot write report: {path}" in result.stdout
    assert "free that much space" in result.stdout
    assert path.read_text(encoding="utf-8") == "the old report"
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_an_impossible_folder_is_reported(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ReportError, match="cannot write report"):
        write_report([run_log()], tmp_path / "file" / "report.html", "Runs", [])


# --- compact and exact ---

meters = st.floats(-2000, 2000)
pose = st.tuples(meters, meters, st.floats(-720, 720))


@settings(max_examples=50)
@given(st.lists(st.dictionaries(st.integers(0, 3), pose), min_size=1, max_size=12))
def test_poses_read_back_to_the_centimeter(poses):
    frames = [
        RunLogFrame(time_s=n / 10, speed_mps=n, poses=tuple((actor, *where) for actor, where in present.items()))
        for n, present in enumerate(poses)
    ]
    run = json.loads(embedded_json(pack([run_log(frames=frames, actors=4)], "", [])))["runs"][0]
    seen = [{} for _ in poses]
    for actor, spells in enumerate(run["tracks"]):
        for first, count, xs, ys, yaws in spells:
            columns = [expand(column, count) for column in (xs, ys, yaws)]
            for n, (x, y, yaw) in enumerate(zip(*columns, strict=True)):
                seen[first + n][actor] = (x / 100, y / 100, yaw / 10)
    for present, found in zip(poses, seen, strict=True):
        assert found.keys() == present.keys()
        for actor, (x, y, yaw) in present.items():
            assert found[actor][:2] == pytest.approx((x, y), abs=0.0051)
            assert abs(math.remainder(found[actor][2] - yaw, 360)) < 0.0501
    assert expand(run["time"], len(poses)) == [100 * n for n in range(len(poses))]


@given(st.lists(st.integers()))
def test_series_read_back(values):
    assert expand(series(values), len(values)) == values


def expand(packed, count):
    return [packed] * count if isinstance(packed, int) else list(accumulate(packed))


def test_lights_and_paths_are_kept_as_changes():
    path = ((0, 0), (1, 0), (2, 0), (2, 5))
    frames = [
        RunLogFrame(time_s=0, speed_mps=0, poses=(), lights=((1, 2, "red"),)),
        RunLogFrame(time_s=1, speed_mps=0, poses=(), lights=((1, 2, "red"),), path=path),
        RunLogFrame(time_s=2, speed_mps=0, poses=(), path=path),
        RunLogFrame(time_s=3, speed_mps=0, poses=(), lights=((1, 2, "green"),)),
    ]
    run = pack([run_log(frames=frames)], "", [])["runs"][0]
    assert run["lights"] == [[100, 200, [[0, "red"], [2, None], [3, "green"]]]]
    assert run["paths"] == [[0, None], [1, [3, [0, 200, 0], [0, 0, 500]]], [3, None]]


@pytest.mark.integration
def test_four_long_busy_runs_stay_small(tmp_path):
    def busy_frame(n):
        poses = ((a, n * 0.83 + a, 3.5 * math.sin(n / 9 + a), n * 0.3 + a) for a in range(60))
        return RunLogFrame(time_s=n / 10, speed_mps=8 + math.sin(n), poses=tuple(poses))

    run = run_log(frames=[busy_frame(n) for n in range(1200)], actors=60)
    write_report([run] * 4, tmp_path / "report.html", "Runs", [])
    assert (tmp_path / "report.html").stat().st_size < 6_000_000


def test_report_page_knows_statuses_of_successful_runs():
    """The page contains the status texts of successful runs."""
    assert f'["{COMPLETED}", "{PERFECT}"].includes(status)' in (ASSETS / "palette.js").read_text(encoding="utf-8")
