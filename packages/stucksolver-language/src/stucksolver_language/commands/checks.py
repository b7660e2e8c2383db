"""Checks of `stucksolver doctor` for the interpreter and language models."""

from __future__ import annotations

import os
from collections.abc import Iterator

from stucksolver.commands.doctor import Check, Finding, package


def _words() -> Iterator[Finding]:
    from stucksolver.interpreter import NoInterpreter, find_reader

    reader = find_reader()
    if isinstance(reader, NoInterpreter):
        yield Finding("interpreter", "absent", reader.why.split(";")[0], "install stucksolver-language again")
        return
    try:
        reading = reader.read("please go round it", "")
    except RuntimeError as error:
        yield Finding("interpreter", "broken", str(error), "install stucksolver again")
        return
    yield Finding("interpreter", "ok", f'{reader.name}; "please go round it" is interpreted as {reading.description}')


def _model() -> Iterator[Finding]:
    from stucksolver.privacy.url_redaction import redacted
    from stucksolver_language.llm.api_keys import KEY_VARIABLE
    from stucksolver_language.llm.openai_api import URL_VARIABLE

    key, base = os.environ.get(KEY_VARIABLE), os.environ.get(URL_VARIABLE)
    if key or base:
        yield Finding(
            "language model", "ok", f"{KEY_VARIABLE} is set" if key else f"{URL_VARIABLE} is {redacted(base or '')}"
        )
        return
    remedy = f"set {KEY_VARIABLE}, or name your own server: --reasoner openai:MODEL@http://HOST:PORT/v1"
    yield Finding("language model", "absent", "no key and no server; the search needs neither", remedy)


CHECKS: tuple[Check, ...] = (
    _words,
    package("openai", "language models over HTTP", "llm"),
    _model,
)
