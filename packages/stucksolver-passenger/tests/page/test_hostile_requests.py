"""What is sent to harm the server, the page or the car, and what becomes of it."""

from __future__ import annotations

import asyncio

import pytest

pytest.importorskip("fastapi")
from page_serving import HOST, Serving

from stucksolver_passenger.server.rate_limits import BODY_BYTES, TARGET_BYTES

SAY = "/api/vehicles/car-1/say"
EVIL = "http://evil.example"


@pytest.fixture(scope="module")
def served():
    return Serving()


@pytest.fixture
def serving(served):
    """What is refused at the door leaves no trace, so one server does for all."""
    served.commands.clear()
    return served


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:9999", "127.0.0.1", "localhost.evil.example:8000", ""])
@pytest.mark.parametrize("path", ["/", "/api/me", "/openapi.json", "/files/page.js"])
def test_another_name_that_points_here_gets_nothing(serving, host, path):
    """DNS rebinding: the browser still says the name by which it came."""
    answer = serving.get(path, headers={"host": host})
    assert answer.status_code == 421


@pytest.mark.parametrize("origin", [EVIL, "null", f"https://{HOST}", "http://127.0.0.1:8001", f"http://{HOST}.evil"])
def test_pages_of_other_sites_can_neither_read_nor_do(serving, origin):
    assert serving.get("/api/me", headers={"origin": origin}).status_code == 403
    assert serving.post(SAY, {"text": "go"}, headers={"origin": origin}).status_code == 403
    assert serving.commands == []


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_browser_that_says_who_sent_it_is_believed(serving, site):
    assert serving.get("/api/me", headers={"sec-fetch-site": site}).status_code == 403


def test_our_own_page_may(serving):
    headers = {"origin": f"http://{HOST}", "sec-fetch-site": "same-origin"}
    assert serving.post(SAY, {"text": "wait"}, headers=headers).status_code == 200


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""])
def test_a_form_of_another_site_cannot_post(serving, kind):
    """Those are the kinds that a form may send without asking first."""
    answer = serving.client.post(
        SAY, content=b'{"text": "go"}', headers={"content-type": kind, "authorization": f"Bearer {serving.passenger}"}
    )
    assert answer.status_code == 415
    assert serving.commands == []


@pytest.mark.parametrize("size", [BODY_BYTES + 1, 1_000_000])
def test_a_megabyte_is_not_read(serving, size):
    assert serving.post(SAY, {"text": "x" * size}).status_code == 413


def test_body_without_length_is_read_only_to_limit():
    """A large body without a stated length is rejected with status 413 once the limit has been read."""
    serving, read = Serving(), []

    async def receive():
        read.append(1)
        return {"type": "http.request", "body": b"x" * 1000, "more_body": True}

    sent = []

    async def send(message):
        sent.append(message)

    headers = [(b"host", HOST.encode()), (b"content-type", b"application/json")]
    scope = {"type": "http", "method": "POST", "path": SAY, "raw_path": SAY.encode(), "headers": headers}
    asyncio.run(serving.client.app(scope, receive, send))
    assert sent[0]["status"] == 413
    assert len(read) == BODY_BYTES // 1000 + 1


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"text": ""},
        {"text": "x" * 501},
        {"text": 5},
        {"text": ["go"]},
        {"text": "go", "by": "operator"},
        {"text": "go", "client": "<script>"},
        {"text": "go", "client": "x" * 41},
        [],
    ],
)
def test_what_is_not_as_the_api_has_it_is_refused(serving, body):
    assert serving.post(SAY, body).status_code == 422
    assert serving.commands == []


def test_markup_is_handed_on_as_the_text_that_it_is(serving):
    text = "<img src=x onerror=alert(1)>"
    serving.say(text)
    assert serving.commands[0].text == text


@pytest.mark.parametrize(
    "path", ["/files/../app.py", "/files/..%2fapp.py", "/files/%2e%2e/seat.py", "/files/.env", "/x"]
)
def test_only_the_pages_own_files_are_served(serving, path):
    assert serving.get(path).status_code in (404, 421)


def test_an_endless_address_is_refused(serving):
    assert serving.get("/api/me?" + "x" * TARGET_BYTES).status_code == 414


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"])
def test_other_methods_are_not_served(serving, method):
    assert serving.client.request(method, SAY).status_code == 405


def test_a_header_that_decides_must_not_stand_there_twice():
    serving, sent = Serving(), []

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": "http.request", "body": b""}

    headers = [(b"host", HOST.encode()), (b"host", b"evil.example")]
    scope = {"type": "http", "method": "GET", "path": "/", "raw_path": b"/", "headers": headers}
    asyncio.run(serving.client.app(scope, receive, send))
    assert sent[0]["status"] == 400


@pytest.mark.parametrize("path", ["/", "/docs", "/files/page.js", "/api/me", "/nothing", "/openapi.json"])
def test_response_headers_forbid_foreign_scripts_and_caching(serving, path):
    """Every response forbids the browser to run scripts of other origins or to store the page."""
    headers = serving.get(path).headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy and "script-src 'self'" in policy
    assert "unsafe" not in policy and "*" not in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cache-control"] == "no-store"
    assert headers["referrer-policy"] == "no-referrer"
    assert "access-control-allow-origin" not in headers


def test_a_refusal_has_them_too(serving):
    assert "default-src 'none'" in serving.get("/", headers={"host": "evil"}).headers["content-security-policy"]
