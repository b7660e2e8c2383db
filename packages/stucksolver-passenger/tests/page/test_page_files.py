"""The page's files: plain, whole, and without anything from elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import stucksolver_passenger

WEB = Path(stucksolver_passenger.__file__).parent / "web"
FILES = sorted(path for path in WEB.iterdir() if path.suffix in (".html", ".js", ".css"))
MAKES_MARKUP = ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function", "srcdoc")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_nothing_comes_from_another_host(file):
    text = file.read_text(encoding="utf-8")
    assert not re.search(r"https?://|\"//|url\(", text.replace("http://www.w3.org/", ""))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_nothing_is_made_of_markup(file):
    text = file.read_text(encoding="utf-8")
    assert not [word for word in MAKES_MARKUP if word in text]


@pytest.mark.parametrize("name", ["index.html", "docs.html"])
def test_no_script_and_no_style_stands_in_the_page_itself(name):
    text = (WEB / name).read_text(encoding="utf-8")
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=|javascript:", text)


def test_every_control_has_a_name():
    text = (WEB / "index.html").read_text(encoding="utf-8")
    for tag, attributes in re.findall(r"<(input|select)\b([^>]*)>", text):
        name = re.search(r'id="([\w-]+)"', attributes)
        assert name and f'for="{name[1]}"' in text, (tag, attributes)
    assert all(label.strip() for label in re.findall(r"<button[^>]*>([^<]*)</button>", text))
