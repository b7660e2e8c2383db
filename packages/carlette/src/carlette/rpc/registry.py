"""The methods that a client can call, by name. `handlers` has one file per topic."""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable, Iterable
from typing import Any

from carlette.errors import RequestError
from carlette.wire import encode

Handler = Callable[..., Any]
"""Takes the session and the request's arguments, and returns the value of the response."""
Call = Callable[..., Any]
"""Like a handler, but it returns the whole response and does not raise on bad arguments."""

log = logging.getLogger(__name__)

BAD_ARGUMENTS = (
    TypeError,
    ValueError,
    IndexError,
    OverflowError,
    AttributeError,
    KeyError,
    RuntimeError,
    struct.error,
)
"""Errors of reading arguments of the wrong shape. RuntimeError comes from the carla library's map queries."""


class Methods:
    """A table of methods; each name is unique."""

    def __init__(self) -> None:
        self.calls: dict[str, Call] = {}

    def value(self, *names: str) -> Callable[[Handler], Handler]:
        """Register a handler whose response carries its return value."""
        return self._register(names, encode.value, encode.failure)

    def void(self, *names: str) -> Callable[[Handler], Handler]:
        """Register a handler whose response is empty."""
        return self._register(names, lambda _: encode.done(), encode.void_failure)

    def bare(self, *names: str) -> Callable[[Handler], Handler]:
        """Register a handler whose return value is sent unchanged."""
        return self._register(names, lambda result: result, encode.failure)

    def include(self, others: Iterable[Methods]) -> Methods:
        """Add the methods of other tables."""
        for other in others:
            for name, call in other.calls.items():
                self._add(name, call)
        return self

    def _register(
        self, names: tuple[str, ...], success: Callable[[Any], Any], failure: Callable[[str], Any]
    ) -> Callable[[Handler], Handler]:
        def decorate(handler: Handler) -> Handler:
            for name in names:
                self._add(name, _guarded(name, handler, success, failure))
            return handler

        return decorate

    def _add(self, name: str, call: Call) -> None:
        if name in self.calls:
            raise ValueError(f"the method '{name}' is registered twice; each name has one handler")
        self.calls[name] = call


def _guarded(name: str, handler: Handler, success: Callable[[Any], Any], failure: Callable[[str], Any]) -> Call:
    def call(*arguments: Any) -> Any:
        try:
            return success(handler(*arguments))
        except RequestError as error:
            # The error becomes the reply, so that the server continues for all clients.
            return failure(str(error))
        except BAD_ARGUMENTS as error:
            # The error becomes the reply, so that the server continues for all clients.
            log.warning("bad arguments of %s: %s: %s", name, type(error).__name__, error)
            return failure(f"{name}: the arguments cannot be read ({type(error).__name__}: {error})")
        except Exception as error:
            # Catch everything: the request of one client must not end the server for all others.
            log.exception("%s failed", name)
            return failure(f"{name} failed in the server ({type(error).__name__}: {error}); its log says where")

    return call
