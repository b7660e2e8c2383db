"""A spoken sentence arrives at the car as text: Chromium, with a microphone that plays a file."""

from __future__ import annotations

import re
import shutil
import subprocess
import wave

import pytest
from riding import DRAWING, Riding
from sitting import PASSENGER_ASKED, parked

from stucksolver_passenger.server.options import PageOptions
from stucksolver_passenger.server.process import PassengerServer
from stucksolver_passenger.speech_recognizer import RecognizerError, install

pytestmark = pytest.mark.integration

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
pytest.importorskip("onnxruntime", reason="the extra `words` is not installed")
CHROMIUM, SPEAKER = shutil.which("chromium"), shutil.which("espeak-ng")
if CHROMIUM is None or SPEAKER is None:
    pytest.skip("needs apt-get install chromium espeak-ng", allow_module_level=True)

expect = playwright.expect
SPOKEN = "Please go around it."
BEFORE_S = 1.5
"""Nobody speaks before the page says that it listens."""
QUIET_S = 0.7
HEARD_MS = 60_000
"""For the model to load and to listen, on a busy machine."""


@pytest.fixture(scope="module")
def recognizer(tmp_path_factory):
    try:
        return install(tmp_path_factory.mktemp("data") / "voice")
    except RecognizerError as error:
        pytest.skip(f"the recognizer cannot be fetched: {error}")


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """What the microphone plays: the sentence, said by a machine."""
    file = tmp_path_factory.mktemp("sound") / "spoken.wav"
    subprocess.run([SPEAKER, "-v", "en-gb", "-s", "150", "-w", str(file), SPOKEN], check=True)
    with wave.open(str(file)) as said:
        form, frames = said.getparams(), said.readframes(said.getnframes())
    with wave.open(str(file), "wb") as later:
        later.setparams(form)
        later.writeframes(bytes(2 * int(BEFORE_S * form.framerate)) + frames)
    return file


@pytest.fixture
def page(sound):
    """A page with that microphone; `elsewhere` has what it asks of anybody but the server."""
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    flags += ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
    flags += [f"--use-file-for-fake-audio-capture={sound}%noloop"]
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=flags)
        context = browser.new_context(permissions=["microphone"])
        opened = context.new_page()
        opened.elsewhere, opened.wrong = [], []
        opened.on("pageerror", lambda error: opened.wrong.append(str(error)))
        opened.on("console", lambda said: opened.wrong.append(said.text) if said.type == "error" else None)
        context.on(
            "request",
            lambda sent: (
                None
                if sent.url.startswith(("http://127.0.0.1:", "data:", "blob:"))
                else opened.elsewhere.append(sent.url)
            ),
        )
        yield opened
        browser.close()


def test_voice_spoken_request_is_executed_and_audio_stays_local(page, recognizer):
    """A request spoken into the microphone is understood and executed, and no sound leaves the browser."""
    posted = []
    page.on("request", lambda sent: posted.append(sent.post_data or "") if sent.method == "POST" else None)
    with (
        PassengerServer(PageOptions(drawing=DRAWING, recognizer=recognizer)) as server,
        Riding(server, "spoken", parked(), PASSENGER_ASKED, tempo=1.0) as ride,
    ):
        page.goto(server.url(server.tokens.passenger("spoken")))
        expect(page.locator("#listen-note")).to_contain_text("the sound stays on this device")
        page.click("#listen")
        page.click("#speak")
        line = page.locator("#lines .passenger")
        expect(line).to_contain_text("go around it", timeout=HEARD_MS)
        # A request, or the answer to the car's question where it has asked by then.
        expect(line).to_contain_text(re.compile("understood: (yes|overtake)"), timeout=20_000)
        ride.tempo = 4.0
        expect(page.locator("#lines")).to_contain_text("Done. I drive on.", timeout=20_000)
    assert page.elsewhere == [] and page.wrong == []
    assert len(posted) == 1 and len(posted[0]) < 300


def test_voice_without_recognizer_warns_that_browser_may_send_audio(page):
    """Without the recognizer, the page says that the browser may send the sound to its vendor."""
    with (
        PassengerServer(PageOptions(drawing=DRAWING)) as server,
        Riding(server, "unspoken", parked(), PASSENGER_ASKED),
    ):
        page.goto(server.url(server.tokens.passenger("unspoken")))
        expect(page.locator("#listen-note")).to_contain_text("some browsers send what you say to their vendor")
        assert page.evaluate("fetch('/voice').then((answer) => answer.json())") == {"version": None}
