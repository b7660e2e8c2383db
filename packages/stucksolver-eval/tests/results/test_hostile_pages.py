"""Pages of results that somebody else made: names and texts stay text, whatever they are."""

from __future__ import annotations

import gzip
import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st
from stores import ORIGIN, begun, keep, manifest, record
from test_evaluation_pages import DECISION

from stucksolver.record.hash_chain import ChainWriter
from stucksolver_eval.criteria import Infraction
from stucksolver_eval.metrics.run_result import run_result
from stucksolver_eval.metrics.summary import summarize
from stucksolver_eval.report import markup, write_report
from stucksolver_eval.report.comparison import write_comparison
from stucksolver_eval.report.evaluation import write_evaluation
from stucksolver_eval.results.checkpoint import save_name
from stucksolver_eval.results.manifest import suite_digest
from stucksolver_eval.results.outcome import TimedInfraction
from stucksolver_eval.results.run_log import ActorInfo, DecisionMoment, LogEvent, MapView, Marking, RunLog
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec

PAYLOADS = (
    '"><meta http-equiv=refresh content="0;url=https://evil.invalid/"><x y="',
    "</script><script>window.hit=1;alert(1)</script>",
    "<img src=x onerror=window.hit=1>",
    "' onmouseover='window.hit=1' x='",
    "javascript:window.hit=1//",
    "</style><svg onload=window.hit=1><style>*{background:url(https://evil.invalid/)}",
    "</title><iframe srcdoc='<script>top.hit=1</script>'></iframe>",
    "--><base href=//evil.invalid> &lt; {{DATA}} \u2028\u202e",
)
ALLOWED = set(
    re.findall(
        "[a-z0-9]+",
        "html head meta title style body header main section h1 h2 p code table thead tbody tr th td div a svg rect "
        "details summary script noscript ul li",
    )
)
SAFE_ATTRIBUTES = set(
    re.findall(
        "[a-z-]+",
        "lang charset name content http-equiv aria-labelledby aria-label aria-hidden id class scope tabindex role href "
        "viewbox width height type",
    )
)


class Elements(HTMLParser):
    """The elements of a page with their attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))


def elements_of(path: Path) -> list[tuple[str, dict[str, str | None]]]:
    """Return a page's elements, all of them of kinds that our pages have, with links that stay in the folder."""
    found = Elements(path.read_text(encoding="utf-8")).found
    assert {tag for tag, _ in found} <= ALLOWED
    assert {name for _, attributes in found for name in attributes} <= SAFE_ATTRIBUTES
    assert not [a for tag, a in found if tag == "meta" and (a.get("http-equiv") or "").lower() == "refresh"]
    for href in (a["href"] for tag, a in found if tag == "a"):
        parts = urlsplit(href or "")
        assert (parts.scheme, parts.netloc, parts.query) == ("", "", ""), href
        assert (path.parent / unquote(parts.path)).exists(), href
    ids = [a["id"] for _, a in found if a.get("id")]
    assert all(re.fullmatch(r"[a-z0-9-]+", object_id or "") for object_id in ids)
    assert "Content-Security-Policy" in {a.get("http-equiv") for tag, a in found if tag == "meta"}
    return found


def hostile_route(bad: str, number: int) -> Route:
    spec = ScenarioSpec(f"{bad}_{number}", bad, RoutePose(ORIGIN, 0.0), {})
    return Route(f"{number}{bad}", f"town{bad}", (ORIGIN, Position(100.0, 0.0, 0.0)), (), (spec,))


def hostile_log(bad: str, result) -> RunLog:
    decision = {
        **DECISION,
        "rationale": bad,
        "observation": {"controls": [{"kind": bad}], "participants": [{"kind": bad, "object_id": bad}], "summary": bad},
        "analysis": {**DECISION["analysis"], "reason": bad, "steps": [{"id": bad, "answer": bad, bad: bad}]},
        "plan": {"behaviors": [{"name": bad, bad: bad}], "route_start": bad, "replan_route": True},
    }
    moment = DecisionMoment(time_s=1.0, trigger=bad, decision=decision, outcome="refused", verdict=bad, picture=bad)
    return RunLog(
        scenario=bad,
        arm=bad,
        seed=1,
        driver=bad,
        reasoner=bad,
        clock=bad,
        perception=bad,
        map=MapView(name=bad, lanes=(), markings=(Marking(points=((0, 0), (9, 0)), kind="solid", color=bad),)),
        route=((0.0, 0.0), (9.0, 0.0)),
        actors=(ActorInfo(label=bad, kind=bad, length_m=4.5, width_m=1.9, role="ego"),),
        frames=(),
        stuck=((1.0, 2.0),),
        decisions=(moment,),
        events=(LogEvent(time_s=1.0, kind="guidance", text=bad),),
        result=result,
    )


def hostile_store(folder: Path, bad: str, *, recorded: bool, **changes: object) -> ResultStore:
    """A store whose every name and text is hostile: one drive with a replay, one with a record."""
    routes = tuple(hostile_route(bad, number) for number in (1, 2))
    store = ResultStore(folder)
    names = dict.fromkeys(("driver", "recovery", "reasoner", "clock", "perception", "simulator", "command"), bad)
    about = manifest(suite=f"{bad}/{bad}", guidance=bad, prompt=bad, suite_digest=suite_digest(routes), **names)
    store.begin(about.model_copy(update=changes), routes, resume=False)
    for route, percent in zip(routes, (100.0, 40.0 if recorded else 100.0), strict=True):
        infraction = Infraction("collisions_vehicle", 1.0, bad)
        kept = record(route, percent, None if percent == 100.0 else bad, infraction)
        keep(store, route, 1, kept)
        outcome = store.outcome(route, 1)
        assert outcome is not None
        noted = TimedInfraction(kind=bad, time_s=1.0, text=bad)
        outcome = outcome.model_copy(update={"reason": f"line\n{bad}", "infractions": (noted,), "arm": bad})
        store.write_outcome(route, outcome)
        kept_at = store.record(route, 1)
        assert kept_at is not None
        if route is routes[0]:
            replay = store.replay(route, 1)
            replay.parent.mkdir(parents=True, exist_ok=True)
            log = hostile_log(bad, run_result(kept_at, outcome, 1))
            replay.write_bytes(gzip.compress(log.model_dump_json().encode()))
        elif recorded:
            write_record(store.interventions(route, 1), bad)
    return store


def write_record(folder: Path, bad: str) -> None:
    folder.mkdir(parents=True)
    chain = ChainWriter(folder / "intervention-0001.jsonl")
    chain.write({"kind": "begin"})
    told = {"event": {"time_s": 12.345, "kind": "decided", "text": bad, "trigger": bad}}
    decision = {**DECISION, "rationale": bad}
    chain.write({"kind": "step", "in": {"answer": {"reasoner": bad, "decision": decision}}, "told": [told]})
    chain.close()


def all_pages(folder: Path, bad: str) -> list[Path]:
    """Write every kind of page from two hostile stores, in folders with hostile names."""
    # Without UTF-8 a file's name holds only what the system's encoding can write.
    encoding = sys.getfilesystemencoding()
    within = bad.replace("/", "%").encode(encoding, "replace").decode(encoding)
    stores = [hostile_store(folder / f"{k}{within}"[:120], bad, recorded=k == 1) for k in range(2)]
    stores.append(hostile_store(folder / "javascript:window.hit=1", bad, recorded=False, reasoner=""))
    summaries = [summarize(item) for item in stores]
    for store, summary in zip(stores, summaries, strict=True):
        write_evaluation(store, summary)
    write_comparison([item.folder for item in stores], summaries, folder / "compared.html")
    return sorted(folder.rglob("*.html"))


@pytest.mark.parametrize("bad", PAYLOADS)
def test_pages_with_hostile_names_hold_only_our_elements(tmp_path, bad):
    """Scenario, route, town, file, actor, run and reason names, and every text of a decision."""
    pages = all_pages(tmp_path, bad)
    assert len(pages) == 3 + 3 + 1 + 1, "evaluations, replays, decisions, comparison"
    for page in pages:
        scripts = [tag for tag, _ in elements_of(page)].count("script")
        assert scripts == (2 if 'id="data"' in page.read_text(encoding="utf-8") else 0)


def test_comparison_keeps_two_hostile_run_names_as_text(tmp_path):
    """A run's name was written into an attribute as it was: the browser left the page."""
    stores = [begun(tmp_path / f"{k}", recovery=PAYLOADS[0] + str(k)) for k in range(2)]
    write_comparison([store.folder for store in stores], [summarize(store) for store in stores], tmp_path / "page.html")
    elements_of(tmp_path / "page.html")
    assert "Differences to driver + &quot;&gt;&lt;meta" in (tmp_path / "page.html").read_text(encoding="utf-8")


@given(st.text())
def test_section_of_any_name_has_a_plain_anchor(name):
    (opening, _), *_ = [Elements(markup.section(name)).found[0:2]]
    anchor = opening[1]["aria-labelledby"]
    assert anchor and re.fullmatch(r"[a-z0-9-]+", anchor)


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_link_to_any_name_is_relative_and_leads_there(name):
    ((_, attributes),) = Elements(markup.link(f"a/{name}", "words")).found
    href = attributes["href"] or ""
    assert urlsplit(href)[:2] == ("", "") and unquote(urlsplit(href).path) == f"a/{name}"
    ((_, attributes),) = Elements(markup.link(name, "words")).found
    assert not re.match(r"[a-zA-Z][a-zA-Z0-9+.-]*:", attributes["href"] or "")


@given(st.text(), st.text(), st.text())
def test_route_file_name_stays_in_folder_for_any_text(route_id, town, scenario):
    """The file name of a route stays in its folder, whatever the names of the route contain."""
    name = save_name(route_id, town, scenario)
    assert Path(name).name == name and "\0" not in name


def test_files_of_two_routes_differ_where_their_names_do():
    assert save_name("a", "t", "\u2028") != save_name("a", "t", "\u02028"), "no two routes share a file"
    assert save_name("a/b", "town", "x") != save_name("a%2Fb", "town", "x") != save_name("a_b", "town", "x")


def test_embedded_data_of_a_hostile_run_reads_back(tmp_path):
    bad = PAYLOADS[1]
    store = hostile_store(tmp_path / "one", bad, recorded=False)
    log = store.run_log(store.routes()[0], 1)
    write_report([log], tmp_path / "page.html", bad, [bad])
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])
    assert (data["title"], data["runs"][0]["scenario"]) == (bad, bad)
