"""Where keys go, and where they never go: real servers, and everything that a hostile server or folder may try."""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
from importlib.util import find_spec

import pytest
from chat_server import ChatServer, Fault
from test_servers import good, scene

from stucksolver.privacy.url_redaction import KEYS_VARIABLE, redacted
from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.reasoners.factory import make_reasoner, preflight
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver_language.llm.api_keys import credentials_for, origin_of
from stucksolver_language.llm.server_text import clean, printable

if find_spec("openai") is None:
    pytest.skip("the openai package is not installed: pip install 'stucksolver[llm]'", allow_module_level=True)

KEY, AZURE_KEY, OWN_KEY = "sk-openai-4711", "azure-0815", "own-2342"
LOGIN = "anna:pa55-word"


@pytest.fixture(autouse=True)
def keys(monkeypatch):
    """Somebody with keys of OpenAI and Azure."""
    for name in ("OPENAI_BASE_URL", KEYS_VARIABLE, "OPENAI_ORG_ID"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("AZURE_OPENAI_API_KEY", AZURE_KEY)


def authorization(url):
    return credentials_for(url).headers.get("authorization", credentials_for(url).headers.get("api-key", ""))


@pytest.mark.parametrize(
    "url",
    [
        None,
        "https://api.openai.com/v1",
        "https://API.OpenAI.com:443/v1",
        "https://api.openai.com./v1",
        "https://eu.api.openai.com/v1",
    ],
)
def test_key_is_sent_to_openai(url):
    assert authorization(url) == f"Bearer {KEY}"


FOREIGN = [
    "http://api.openai.com/v1",
    "https://openai.com/v1",
    "https://api.openai.com.evil.example/v1",
    "https://evil-api.openai.com.example/v1",
    "https://notapi.openai.com/v1",
    "https://xapi.openai.com/v1",
    "https://evil.example/api.openai.com/v1",
    "https://evil.example/v1?api-version=api.openai.com",
    "http://127.0.0.1:8000/v1",
    "https://127.0.0.1/v1",
    "http://[::1]:8000/v1",
    "http://localhost:8000/v1",
    "https://evil.azure.com/openai/v1",
    "https://evil.eastus.cloudapp.azure.com/openai/v1",
    "http://name.openai.azure.com/openai/v1",
    "https://evil.example/openai/deployments/m?api-version=1",
    "http://evil.example/openai/deployments/m?api-version=1",
    "https://openai.azure.com.evil.example/openai/v1",
]


@pytest.mark.parametrize("url", FOREIGN)
def test_key_is_not_sent_to_another_server(url):
    found = credentials_for(url)
    assert found.headers == {}
    assert "gets no key" in found.note and KEY not in found.note


@pytest.mark.parametrize(
    "url",
    [
        "https://api.openai.com\\@evil.example/v1",
        "https://evil.example\\.api.openai.com/v1",
        "https://evil.example%2f.api.openai.com/v1",
        "https://evil.example\t.api.openai.com/v1",
        "https://evil.example\u3002api.openai.com/v1",
        "https://ev\u200bil.api.openai.com/v1",
        "https://[api.openai.com]/v1",
        "https://api.openai.com:x/v1",
        "//api.openai.com/v1",
    ],
)
def test_address_that_parsers_read_differently_is_refused(url):
    with pytest.raises(ValueError, match="not an address"):
        origin_of(url)


def test_azure_key_is_sent_to_microsoft_only():
    assert authorization("https://name.openai.azure.com/openai/v1") == f"Bearer {AZURE_KEY}"
    assert authorization("https://name.openai.azure.com/openai/deployments/m?api-version=1") == AZURE_KEY


@pytest.mark.parametrize(
    ("entry", "url", "sent"),
    [
        ("api.example.com", "https://api.example.com/v1", True),
        ("api.example.com", "https://api.example.com:8443/v1", True),
        ("api.example.com:443", "https://api.example.com/v1", True),
        ("api.example.com:443", "https://api.example.com:8443/v1", False),
        ("api.example.com", "http://api.example.com/v1", False),
        ("http://api.example.com:80", "http://api.example.com/v1", True),
        ("http://api.example.com", "https://api.example.com/v1", False),
        ("api.example.com", "https://api-example.com/v1", False),
        ("api.example.com", "https://x.api.example.com/v1", False),
        ("127.0.0.1", "http://127.0.0.1:8000/v1", True),
        ("127.0.0.1:8000", "http://127.0.0.1:8001/v1", False),
        ("[::1]:8000", "http://[::1]:8000/v1", True),
    ],
)
def test_key_of_a_named_server_is_sent_to_it_only(monkeypatch, entry, url, sent):
    monkeypatch.setenv(KEYS_VARIABLE, f"other.example=nothing {entry}={OWN_KEY}")
    assert authorization(url) == (f"Bearer {OWN_KEY}" if sent else "")


@pytest.mark.parametrize("entry", ["", "x", "=secret", "ht tp", "http://=secret", "a/b\\=secret"])
def test_entry_that_cannot_be_read_is_named_by_its_number(monkeypatch, entry):
    monkeypatch.setenv(KEYS_VARIABLE, f"a.example=b {entry}")
    if not entry:
        assert credentials_for("https://c.example/v1").headers == {}
        return
    with pytest.raises(ValueError, match="entry 2") as told:
        credentials_for("https://c.example/v1")
    assert "secret" not in str(told.value)


# ---- with a server


def test_custom_server_gets_no_key_and_preflight_notes_it(server):
    """A server of the user's is queried without a key, and the preflight says so."""
    reasoner = make_reasoner(f"openai:reader@{server.url}")
    (note,) = preflight(reasoner, "it")
    assert "gets no key" in note and "--send-key" in note and server.url in note
    assert reasoner.decide(ReasonerRequest(scene(), deadline_s=20.0)).decision.plan is not None
    assert all(not {"authorization", "api-key", "openai-organization"} & headers.keys() for headers in server.headers)


def test_server_without_any_key_in_the_environment_gives_no_note(server, monkeypatch):
    monkeypatch.delenv("OPENAI_API_KEY")
    monkeypatch.delenv("AZURE_OPENAI_API_KEY")
    assert preflight(make_reasoner(f"openai:reader@{server.url}"), "it") == ()
    assert "authorization" not in server.headers[0]


def test_organization_is_sent_to_openai_only(server, monkeypatch):
    monkeypatch.setenv("OPENAI_ORG_ID", "org-1")
    monkeypatch.setenv("OPENAI_PROJECT_ID", "proj-1")
    preflight(make_reasoner(f"openai:reader@{server.url}"), "it")
    assert "org-1" not in str(server.headers) and "proj-1" not in str(server.headers)


def test_key_of_the_server_is_sent_and_told(server, monkeypatch):
    monkeypatch.setenv(KEYS_VARIABLE, f"{server.url.removesuffix('/v1')}={OWN_KEY}")
    (note,) = preflight(make_reasoner(f"openai:reader@{server.url}"), "it")
    assert server.headers[0]["authorization"] == f"Bearer {OWN_KEY}"
    assert KEYS_VARIABLE in note and OWN_KEY not in note


def test_custom_server_requiring_key_names_the_remedy(server):
    """If the server requires a key and none was sent, the error names --send-key."""
    server.key = "right"
    with pytest.raises(ReasonerNameError, match=r"none was sent: --send-key sends OPENAI_API_KEY"):
        preflight(make_reasoner(f"openai:reader@{server.url}"), "it")


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
@pytest.mark.parametrize(
    "target", ["{other}/chat/completions", "{here}/elsewhere", "http://u:" + OWN_KEY + "@h/?k={key}"]
)
def test_redirect_is_not_followed(server, monkeypatch, status, target):
    """Neither the key nor the scene goes to a server that nobody named."""
    monkeypatch.setenv(KEYS_VARIABLE, f"{server.url.removesuffix('/v1')}={OWN_KEY}")
    with ChatServer() as other:
        where = target.format(other=other.url, here=server.url, key=OWN_KEY)
        server.faults.extend([Fault(status=status, body=b"{}", headers={"location": where})] * 3)
        with pytest.raises(ReasonerNameError, match="not followed") as told:
            preflight(make_reasoner(f"openai:reader@{server.url}"), "it")
        assert other.requests == [] and len(server.requests) == 1
    assert OWN_KEY not in str(told.value)


ECHOES = {
    "as it is": lambda key: f"wrong key {key}!",
    "quoted": lambda key: f"?key={key.replace('-', '%2D')}&a={key}",
    "in base 64": lambda key: base64.b64encode(key.encode()).decode(),
    "with a space of no width": lambda key: key[:4] + "\u200b" + key[4:],
    "with a control sequence": lambda key: key[:4] + "\x1b[31m" + key[4:],
    "the other key": lambda key: f"{KEY} {AZURE_KEY}",
}


@pytest.mark.parametrize("echo", ECHOES)
@pytest.mark.parametrize("status", [400, 404, 418, 500])
def test_error_of_a_server_does_not_show_the_key(server, monkeypatch, echo, status):
    monkeypatch.setenv(KEYS_VARIABLE, f"{server.url.removesuffix('/v1')}={OWN_KEY}")
    said = ECHOES[echo](OWN_KEY)
    server.faults.extend([Fault(status=status, error={"message": said})] * 9)
    with pytest.raises(ReasonerError) as told:
        make_reasoner(f"openai:reader@{server.url}#call=prose").decide(ReasonerRequest(scene(), deadline_s=20.0))
    text = str(told.value)
    assert not any(key in text for key in (OWN_KEY, KEY, AZURE_KEY, ECHOES["in base 64"](OWN_KEY)))
    assert text.isprintable()


def escaped(text):
    return "".join(f"\\u{ord(c):04x}" for c in text)


@pytest.mark.parametrize("prose", [False, True])
@pytest.mark.parametrize("key", [OWN_KEY, KEY, LOGIN.partition(":")[2]])
def test_answer_of_a_server_is_stored_without_the_key(server, monkeypatch, tmp_path, prose, key):
    """Also if JSON writes it as escapes, and in prose around the JSON."""
    monkeypatch.setenv(KEYS_VARIABLE, f"{server.url.removesuffix('/v1')}={OWN_KEY}")
    sc = scene()
    answer = good(sc)
    answer["decision"]["rationale"] = "RATIONALE"
    text = json.dumps(answer).replace("RATIONALE", f"{key} {escaped(key)} \\u001b[31mred\\u009b0m\\u202e")
    server.faults.append(Fault(message={"role": "assistant", "content": f"Here: {key}\n{text}" if prose else text}))
    url = server.url.replace("http://", f"http://{LOGIN}@")
    made = make_reasoner(f"openai:reader@{url}", tmp_path).decide(ReasonerRequest(sc, deadline_s=20.0))
    assert key not in made.decision.rationale and "red" in made.decision.rationale
    assert made.decision.rationale.isprintable()
    stored = (tmp_path / "exchanges.jsonl").read_text(encoding="utf-8")
    for item in json.loads(stored), stored:
        assert key not in str(item)


@pytest.mark.parametrize(
    "login", [LOGIN, "anna:p%40ss%2Fword", "token-4711", ":pa55-word", "anna:pa55#word", "anna:pa55?word", "a@b:pa55"]
)
def test_login_of_an_address_is_sent_and_shown_nowhere(server, tmp_path, login):
    url = server.url.replace("http://", f"http://{login}@")
    reasoner = make_reasoner(f"openai:reader@{url}", tmp_path)
    notes = preflight(reasoner, "it")
    reasoner.decide(ReasonerRequest(scene(), deadline_s=20.0))
    assert server.headers[0]["authorization"].startswith("Basic ")
    shown_texts = [*notes, reasoner.name, str(reasoner), (tmp_path / "exchanges.jsonl").read_text(encoding="utf-8")]
    parts = [part for part in login.split(":") if len(part) > 3]
    assert not [part for part in parts for text in shown_texts if part in text]


@pytest.mark.parametrize(
    "name",
    [
        "openai:m@http://anna:pa55/word@h/v1",
        "openai:m@http://anna:pa55 word@h/v1",
        "openai:m@http://anna:pa55,word@h/v1",
        "openai:m@ftp://anna:pa55word@h/v1",
        "openai:m@http://anna:pa55word@",
        "openai:m@http://anna:pa55word@h:x/v1",
        "openai:m@http://h/v1?key=pa55word",
        "openai:m@http://anna:pa55word@h/v1#key=1",
        "opnai:m@http://anna:pa55word@h/v1",
        "rules, opnai:m@http://anna:pa55word@h/v1",
    ],
)
def test_error_about_a_name_does_not_show_its_login(name):
    with pytest.raises(ReasonerNameError) as told:
        make_reasoner(name)
    assert "pa55" not in str(told.value)


def test_names_without_logins_are_shown_as_they_are():
    for name in ("openai:a@http://h1:1/v1,openai:b@http://h2/v1", "openai:m", "rules", "openai:m@https://h,rules"):
        assert redacted(name) == name


@pytest.mark.parametrize(
    "text",
    [
        "\x1b[2J\x1b[Hred",
        "\x1b]0;title\x07red",
        "\x9b31mred",
        "r\x08ed\x7f",
        "\u202ered\u2066",
        "\x1bPq\x1b\\red",
        "re\x00d",
    ],
)
def test_text_of_a_server_moves_no_cursor(text):
    assert printable(text) == clean(text) == "red"


# ---- the command line


def stucksolver(*words, folder, **environment):
    """The command, in a folder of its own."""
    command = [sys.executable, "-m", "stucksolver", *words]
    env = {**os.environ, "OPENAI_API_KEY": KEY, **environment}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False, env=env)


@pytest.mark.integration
@pytest.mark.parametrize("own", [False, True])
def test_configuration_file_of_a_folder_gets_no_key(server, tmp_path, own):
    """Here a file that somebody else wrote names the server; with `--send-key` the user lets it have the key."""
    server.key = KEY
    (tmp_path / "stucksolver.toml").write_text(
        f'[cases]\nreasoner = "openai:absent@{server.url}"\nout = "out"\n', encoding="utf-8"
    )
    done = stucksolver("cases", *(["--send-key"] if own else []), folder=tmp_path)
    assert done.returncode == 2
    assert ("no model 'absent'" if own else "none was sent") in done.stderr
    assert server.headers[0].get("authorization") == (f"Bearer {KEY}" if own else None)
    assert KEY not in done.stderr + done.stdout


@pytest.mark.integration
@pytest.mark.parametrize("place", ["argument", "file", "variable"])
def test_login_of_an_address_is_not_printed(server, tmp_path, place):
    """Nor kept in a result: the words with which a command was called are repeated in many places."""
    name = f"openai:absent@{server.url.replace('http://', f'http://{LOGIN}@')}"
    (tmp_path / "stucksolver.toml").write_text(
        f'[cases]\nreasoner = "{name}"\n' if place == "file" else "", encoding="utf-8"
    )
    words = ["--reasoner", name] if place == "argument" else []
    environment = {"STUCKSOLVER_CASES_REASONER": name} if place == "variable" else {}
    done = stucksolver("cases", "--out", "out", *words, folder=tmp_path, **environment)
    assert "no model 'absent'" in done.stderr
    assert server.headers[0]["authorization"] == f"Basic {base64.b64encode(LOGIN.encode()).decode()}"
    kept = [
        file.read_text(errors="replace", encoding="utf-8") for file in (tmp_path / "out").rglob("*") if file.is_file()
    ]
    assert not [text for text in (done.stdout, done.stderr, *kept) if "anna" in text or "pa55" in text]


@pytest.mark.integration
def test_send_key_is_no_setting(tmp_path):
    """A file cannot say it for the user."""
    (tmp_path / "stucksolver.toml").write_text("[cases]\nsend-key = true\n", encoding="utf-8")
    done = stucksolver("cases", folder=tmp_path)
    assert done.returncode == 2 and "no setting 'send-key'" in done.stderr


@pytest.mark.integration
def test_send_key_without_server_or_key_names_missing_part(tmp_path):
    """With --send-key and without a server or a key, the error names the missing one."""
    assert "no server" in stucksolver("cases", "--send-key", folder=tmp_path).stderr
    words = ("cases", "--send-key", "--reasoner", "openai:m@http://h/v1")
    assert "no key" in stucksolver(*words, folder=tmp_path, OPENAI_API_KEY="").stderr
