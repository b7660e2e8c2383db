"""Checks sensor-based perception for `stucksolver doctor`."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

from stucksolver.commands.doctor import Check, Finding

PERCEPTION = ("numpy", "onnxruntime", "PIL", "scipy", "filterpy")
"""Names of the modules that perception imports."""


def _perception() -> Iterator[Finding]:
    title = "sensor-based perception"
    missing = [name for name in PERCEPTION if importlib.util.find_spec(name) is None]
    if missing:
        yield Finding(
            title, "absent", f"{', '.join(missing)} not installed", "add the extra [perception] (README, Install)"
        )
        return
    from stucksolver_perception.pipeline import unavailable_reason

    reason = unavailable_reason()
    yield Finding(title, "broken" if reason else "ok", reason or "three networks and the rig load")


def _signs() -> Iterator[Finding]:
    from stucksolver_perception.camera.sign_reader import PACKAGE, unavailable_reason

    is_found = unavailable_reason() is None
    remedy = "" if is_found else "add the extra [signs] (README, Install)"
    yield Finding(
        "words on signs", "ok" if is_found else "absent", f"{PACKAGE} {'' if is_found else 'not '}installed", remedy
    )


CHECKS: tuple[Check, ...] = (
    _perception,
    _signs,
)
