"""`stucksolver ride` from the command line to the destination."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest

from stucksolver.commands import main

pytest.importorskip("carla")
pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")

COMMAND = "import sys; from stucksolver.commands import main; sys.exit(main(sys.argv[1:]))"
LIMIT_S = 250.0
"""Who takes longer than that hangs; a busy machine may need a minute."""


def call(url, token, path="", body=None):
    headers = {"authorization": f"Bearer {token}", "content-type": "application/json"}
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url + path, headers=headers, data=data)
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_ride_parked_car_approved_by_passenger_reaches_destination():
    """A ride passes a parked car after the passenger has said yes, and reaches the destination."""
    told = [sys.executable, "-u", "-c", COMMAND, "ride", "--once"]
    with subprocess.Popen(told, stdout=subprocess.PIPE, text=True) as ride:
        assert ride.stdout is not None
        found = re.match(r"passenger: (http://127\.0\.0\.1:\d+)/#(p\.([\w-]+)\.\S+)", ride.stdout.readline())
        assert found, "the page's address is told first"
        url, token = f"{found[1]}/api/vehicles/{found[3]}", found[2]
        assert answered(url, token), "it asks before it uses the oncoming lane"
        ending = ride.stdout.read()
    assert ride.returncode == 0
    assert "arrived after" in ending


def answered(url, token):
    """Say yes to what is asked; was anything?"""
    end = time.monotonic() + LIMIT_S
    while time.monotonic() < end:
        time.sleep(0.5)
        try:
            question = call(url, token)["question"]
        except urllib.error.HTTPError:
            continue
        if question is not None:
            return call(url, token, "/answer", {"yes": True, "question_id": question["id"]})["taken"]
    return False


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--listen", "everywhere"], "not an address of this machine"),
        (["--cert", "x.pem"], "must be given together"),
        (["--ladder", "nowhere.toml"], "no ladder"),
        (["--map", "no_such_town"], "no_such_town"),
        (["--driver", "nobody"], "unknown driver"),
    ],
)
def test_what_cannot_be_done_is_one_line_with_the_remedy(arguments, why, capsys):
    assert main(["ride", *arguments]) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ") and why in told and told.count("\n") == 1


def test_an_evaluation_with_a_passenger_is_one_on_this_machine(tmp_path, capsys):
    told = ["evaluate", "--suite", "dev", "--out", str(tmp_path), "--passenger", "--cluster", "tcp://nowhere:1"]
    assert main(told) == 2
    assert "leave out --sweep and --cluster" in capsys.readouterr().err
