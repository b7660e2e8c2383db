"""Compilation of inner loops by numba on first use; the machine code is cached for later runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])
# Products must not be fused with sums, because an edge must bound both of its faces by the same number.
_OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"nnan", "ninf", "nsz"}}


def compiled(function: Function) -> Function:
    """Compile a function. Without a cache in the file system, every process compiles it again."""
    njit: Any = numba.njit
    try:
        built: Function = njit(function, cache=True, **_OPTIONS)
    except RuntimeError:
        # The folder for the cache is not writable.
        built = njit(function, **_OPTIONS)
    return built
