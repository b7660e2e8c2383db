"""The reports in Debian's Chromium: everybody can read them, and the keyboard is enough."""

from __future__ import annotations

import base64
import io
import re

import pytest
from stores import CRASH, ROUTES, begun, keep, record
from test_hostile_pages import PAYLOADS, all_pages

from grids import sample
from stucksolver_eval.metrics.summary import summarize
from stucksolver_eval.report import write_report
from stucksolver_eval.report.comparison import write_comparison
from stucksolver_eval.report.evaluation import write_evaluation
from stucksolver_eval.results.run_log import DecisionMoment, LogEvent, RunLogFrame
from test_report import DECISION, run_log

pytestmark = pytest.mark.integration

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
expect = playwright.expect
LIMIT_MS = 100_000
"""Who takes longer than that hangs; a busy machine may need many seconds."""
expect.set_options(timeout=LIMIT_MS)

PLACES = {"desktop": {"width": 1400, "height": 1000}, "phone": {"width": 390, "height": 844}}


def waiting(time_s, why):
    """A decision to wait for somebody, and what for."""
    analysis = {**DECISION["analysis"], "wait": "yield"}
    decision = {**DECISION, "analysis": analysis, "plan": None, "rationale": f"wait: {why}"}
    return DecisionMoment(
        time_s=time_s, trigger="detector", decision=decision, outcome="nothing to do", verdict="nothing to do"
    )


def jpeg():
    image = pytest.importorskip("PIL.Image")
    file = io.BytesIO()
    image.new("RGB", (48, 27), "steelblue").save(file, "JPEG")
    return base64.b64encode(file.getvalue()).decode()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """One of each kind of page."""
    folder = tmp_path_factory.mktemp("pages")
    frames = [
        RunLogFrame(time_s=k / 10, speed_mps=max(0.0, 8.0 - k / 5), poses=((0, min(k * 0.6, 60.0), 1.75, 0.0),))
        for k in range(300)
    ]
    taken = DecisionMoment(
        time_s=9.0, trigger="detector", decision=DECISION, outcome="accepted", verdict="accepted", picture=jpeg()
    )
    waits = tuple(waiting(3.0 + k, f"car {11 + k // 3} in the oncoming lane, {30 - 9 * k} m ahead") for k in range(6))
    events = tuple(LogEvent(time_s=k, kind=kind, text="words") for k, kind in enumerate(("guidance", "abort", "run")))
    shown = run_log(frames=frames, decisions=(*waits, taken), events=events, scenario="parked car")
    alone = run_log(frames=frames, arm="driver alone", decisions=(), scenario="parked car")
    replay, decisions = folder / "replay.html", folder / "decisions.html"
    write_report([alone, shown], replay, "Runs", ["a note"])
    write_report([run_log(decisions=(*waits, taken))], decisions, "Decisions")
    stores = []
    for name, percent, infraction in (("none", 60.0, CRASH), ("rules", 100.0, None)):
        stores.append(begun(folder / name, recovery=name, command="stucksolver evaluate --suite two"))
        for of in ROUTES:
            found = record(of, percent, None if percent == 100.0 else "TickRuntime", *filter(None, [infraction]))
            keep(stores[-1], of, 1, found)
    summaries = [summarize(store, stores[0]) for store in stores]
    evaluation = write_evaluation(stores[1], summaries[1])
    compared = folder / "compared.html"
    write_comparison([store.folder for store in stores], summaries, compared)
    return {"replay": replay, "decisions": decisions, "evaluation": evaluation, "comparison": compared}


@pytest.fixture
def look(browser, pages):
    """Opens a page; what it complains of fails the test."""
    contexts, wrong = [], []

    def open_page(name, place="desktop"):
        contexts.append(browser.new_context(viewport=PLACES[place]))
        contexts[-1].set_default_timeout(LIMIT_MS)
        page = contexts[-1].new_page()
        page.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.goto(pages[name].as_uri())
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert wrong == []


@pytest.mark.parametrize("name", ["replay", "decisions", "evaluation", "comparison"])
def test_axe_finds_nothing_in_any_size_and_light(look, violations, name):
    page = look(name)
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true;")
    for place, size in PLACES.items():
        page.set_viewport_size(size)
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            assert violations(page) == [], (place, scheme)
            assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]


@pytest.mark.parametrize("place", PLACES)
def test_the_controls_stay_in_sight_while_the_decisions_are_read(look, place):
    page = look("replay", place)
    page.locator(".logs").evaluate("one => one.scrollIntoView()")
    bar = page.locator(".transport").bounding_box()
    assert bar is not None and bar["y"] >= 0.0 and bar["height"] < 100.0


def test_replay_keys_play_step_and_label_slider(look):
    """The space key plays, the arrow keys step, and the slider has a text for what it shows."""
    page = look("replay")
    time, play = page.locator("input[type=range]"), page.locator(".play")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(time).to_have_value("0.1")
    time.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowRight")
    expect(time).to_have_value("1.05")
    expect(time).to_have_attribute("aria-valuetext", re.compile(r"1\.05 of 29\.9 s: driver alone .*; StuckSolver"))
    for name in ("Pause", "Play"):
        page.keyboard.press("Space")
        expect(play).to_have_text(name)
    play.focus()
    page.keyboard.press("Space")
    expect(play).to_have_text("Pause")


def test_decision_group_summary_names_wait_reasons_in_order(look):
    """The folded line gives the reasons for waiting and names each vehicle once."""
    line = look("replay").locator(".group > summary").inner_text()
    assert "6 × wait" in line and "nothing to do" not in line
    assert "car 11 in the oncoming lane, 30 m ahead" in line and "then car 12 in the oncoming lane" in line
    assert "21 m ahead" not in line, "the same car is named once"


def test_a_decision_shows_what_the_camera_saw(look):
    picture = look("replay").locator("img.seen")
    picture.scroll_into_view_if_needed()
    assert picture.count() == 1 and picture.evaluate("async (one) => { await one.decode(); return one.naturalWidth; }")


def test_report_without_frames_has_no_player_but_all_decisions(look):
    """A report without frames has no player and shows all decisions."""
    page = look("decisions")
    assert page.locator(".transport, canvas").count() == 0
    assert page.locator(".card").count() == 7


@pytest.mark.parametrize("bad", sample(PAYLOADS, 2))
def test_pages_with_hostile_names_run_nothing_and_go_nowhere(browser, tmp_path, bad):
    """In the browser: no script of theirs runs, no dialog opens, nothing is loaded, and the page stays."""
    context = browser.new_context()
    context.set_default_timeout(LIMIT_MS)
    for path in all_pages(tmp_path, bad):
        page, happened = context.new_page(), []
        page.on("dialog", lambda dialog, told=happened: (told.append(dialog.message), dialog.dismiss()))
        page.on("request", lambda request, told=happened: told.append(request.url))
        page.goto(path.as_uri())
        page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true;")
        for link in page.locator("a").all():
            link.hover(force=True)
            assert link.evaluate("one => one.protocol") == "file:"
        page.mouse.move(300, 300)
        assert page.evaluate("window.hit") is None
        assert page.url == path.as_uri()
        assert [url for url in happened if url != path.as_uri() and not url.startswith("data:image/")] == []
        assert page.locator("iframe, base, img[onerror]").count() == 0
        page.close()
    context.close()
