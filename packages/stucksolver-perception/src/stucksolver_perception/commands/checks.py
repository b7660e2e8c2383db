"""Checks of `stucksolver doctor` on perception with sensors."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

from stucksolver.commands.doctor import Check, Finding

PERCEPTION = ("numpy", "onnxruntime", "PIL", "scipy", "filterpy")


def _perception() -> Iterator[Finding]:
    what = "perception by sensors"
    missing = [name for name in PERCEPTION if importlib.util.find_spec(name) is None]
    if missing:
        yield Finding(
            what, "absent", f"{', '.join(missing)} not installed", "add the extra [perception] (README, Install)"
        )
        return
    from stucksolver_perception.pipeline import unavailable_reason

    why = unavailable_reason()
    yield Finding(what, "broken" if why else "ok", why or "three networks and the rig load")


def _signs() -> Iterator[Finding]:
    from stucksolver_perception.camera.sign_reader import PACKAGE, unavailable_reason

    found = unavailable_reason() is None
    remedy = "" if found else "add the extra [signs] (README, Install)"
    yield Finding(
        "words on signs", "ok" if found else "absent", f"{PACKAGE} {'' if found else 'not '}installed", remedy
    )


CHECKS: tuple[Check, ...] = (
    _perception,
    _signs,
)
