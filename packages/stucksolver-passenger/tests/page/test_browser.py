"""The page in Debian's Chromium: a passenger talks to a car that the real solver and guard look after."""

from __future__ import annotations

import pytest
from riding import DRAWING, Riding
from sitting import PASSENGER_ASKED, parked

from stucksolver.ladder.ladder import Approval
from stucksolver_passenger.server.options import PageOptions
from stucksolver_passenger.server.process import PassengerServer
from worlds import ladder

pytestmark = pytest.mark.integration

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
pytest.importorskip("onnxruntime", reason="the extra `words` is not installed")

expect = playwright.expect
LIMIT_MS = 100_000
"""Who takes longer than that hangs; a busy machine may need many seconds."""
expect.set_options(timeout=LIMIT_MS)
DESKTOP, PHONE = {"width": 1400, "height": 1000}, {"width": 390, "height": 844}
TARGET_PX = 24
"""WCAG 2.2, 2.5.8: the least size of a target."""


@pytest.fixture(scope="module")
def server():
    with PassengerServer(PageOptions(drawing=DRAWING)) as started:
        yield started


@pytest.fixture
def ride(server, request):
    """Starts a ride of its own for the test; the car is called after it."""
    rides = []

    def start(world=None, policy=PASSENGER_ASKED, **more):
        vehicle = f"t{abs(hash(request.node.name)) % 10**9}"
        rides.append(Riding(server, vehicle, world or parked(), policy, **more).__enter__())
        return rides[-1], server.tokens.passenger(vehicle)

    yield start
    for item in rides:
        item.__exit__()


@pytest.fixture
def look(browser, server):
    """Opens the page with a token; what it complains of, and what it loads from elsewhere, fails the test."""
    contexts, wrong = [], []

    def open_page(token, viewport=DESKTOP, **more):
        contexts.append(browser.new_context(viewport=viewport, **more))
        contexts[-1].set_default_timeout(LIMIT_MS)
        page = contexts[-1].new_page()
        page.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        base = f"http://127.0.0.1:{server.port}/"
        page.on("request", lambda sent: wrong.append(sent.url) if not sent.url.startswith((base, "data:")) else None)
        page.goto(server.url(token))
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert wrong == []


def asked(page):
    expect(page.locator("#yes")).to_be_enabled()
    expect(page.locator("#thought")).to_have_text("A parked car blocks my lane.")


def test_stuck_asked_clicked_gone_round_and_done(ride, look):
    driven, token = ride()
    page = look(token)
    asked(page)
    expect(page.locator("#question")).to_contain_text("May I go round it on the left")
    page.click("#yes")
    expect(page.locator("#thought")).to_have_text("I am going round it on the left.")
    expect(page.locator("#lines")).to_contain_text("Done. I drive on.")
    assert driven.world.x > 80.0
    driven.end()
    expect(page.locator("#thought")).to_have_text("The ride is over.")
    expect(page.locator("#stop")).to_be_disabled()


def test_a_typed_answer_does_the_same(ride, look):
    _, token = ride()
    page = look(token)
    asked(page)
    page.fill("#words", "yes please")
    page.press("#words", "Enter")
    expect(page.locator("#lines")).to_contain_text("understood: yes")
    expect(page.locator("#lines")).to_contain_text("Done. I drive on.")


def test_what_cannot_be_done_is_refused_with_a_reason(ride, look):
    _, token = ride(parked(sight_m=40.0))
    page = look(token)
    page.get_by_role("button", name="Please go round it").click()
    expect(page.locator("#lines")).to_contain_text("I can't: it would not be safe at the moment.")


def test_stop_ends_the_maneuver_under_way(ride, look):
    driven, token = ride(parked(x=50.0, cruise_mps=0.0))
    page = look(token)
    asked(page)
    driven.tempo = 0.25
    page.click("#yes")
    expect(page.locator("#thought")).to_have_text("I am going round it on the left.")
    page.click("#stop")
    expect(page.locator("#lines")).to_contain_text("I have ended that, as you asked.")
    driven.tempo = 4.0
    expect(page.locator("#intention")).to_contain_text("I am waiting, as you asked.")
    assert driven.world.x < 60.0


def test_markup_that_is_said_is_shown_as_what_it_is(ride, look):
    _, token = ride()
    page = look(token)
    text = "<img src=x onerror=alert(1)><b>go</b>"
    page.fill("#words", text)
    page.click("text=Send")
    line = page.locator("#lines .passenger")
    expect(line).to_contain_text(text)
    assert page.locator("#lines img, #lines b").count() == 0


def test_page_on_phone_fits_width_with_large_buttons(ride, look):
    """On a phone, the page fits the width, buttons have at least the target size, and yes needs no scrolling."""
    _, token = ride()
    page = look(token, PHONE)
    asked(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for button in page.get_by_role("button").all():
        box = button.bounding_box()
        assert box is not None and min(box["width"], box["height"]) >= TARGET_PX
    first = page.locator("#yes").bounding_box()
    assert first is not None and first["y"] + first["height"] < PHONE["height"]


def test_a_keyboard_is_enough(ride, look):
    _, token = ride()
    page = look(token)
    asked(page)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "yes"
    style = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert style == "solid"
    page.keyboard.press("Enter")
    expect(page.locator("#lines")).to_contain_text("Done. I drive on.")


def test_page_tab_key_reaches_every_control(ride, look):
    """The tab key reaches every control, and no control keeps the focus."""
    _, token = ride()
    page = look(token)
    asked(page)
    reached = []
    for _ in range(25):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.id || document.activeElement.textContent.trim()"))
    assert {"yes", "no", "stop", "help", "words", "Send", "pause", "lines"} <= set(reached)


def test_without_a_token_the_page_asks_for_it(ride, look, server):
    _, token = ride()
    page = look("")
    expect(page.get_by_label("Code")).to_be_focused()
    page.get_by_label("Code").fill(token)
    page.keyboard.press("Enter")
    asked(page)


def test_the_token_does_not_stay_in_the_address(ride, look):
    _, token = ride()
    page = look(token)
    expect(page.locator("#link")).to_have_text("Connected")
    assert token not in page.url


def test_an_operator_answers_from_the_queue(ride, look, server):
    _, token = ride(policy=ladder(approval=Approval(behaviors={"borrow_oncoming_lane": "operator"})))
    mine, theirs = look(token), look(server.tokens.operator())
    expect(mine.locator("#lines")).to_contain_text("I have asked the operator")
    expect(mine.locator("#yes")).to_be_disabled()
    call = theirs.locator("#queue li", has_text="parked car blocks")
    call.get_by_role("button", name="Yes").first.click()
    expect(mine.locator("#lines")).to_contain_text("I am going round it on the left.")


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("viewport", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_axe_finds_nothing(ride, look, violations, scheme, viewport):
    _, token = ride()
    page = look(token, viewport, color_scheme=scheme)
    asked(page)
    assert violations(page) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_operator_and_api_pages_have_no_axe_violations(ride, look, violations, server, scheme):
    """The checker axe finds no violation on the operator's page and on the page of the API."""
    ride()
    page = look(server.tokens.operator(), color_scheme=scheme)
    expect(page.locator("#thought")).not_to_be_empty()
    assert violations(page) == []
    page.goto(f"http://127.0.0.1:{server.port}/docs")
    expect(page.locator("#rows")).to_contain_text("/say")
    assert violations(page) == []
