"""Fast copies of a world: everything is copied except constant data, which the original and the copy share.

A fork is a pickle round trip, so it holds exactly the content of a pickle of the world. Only instances of classes
decorated with `shared` are passed by reference.
"""

from __future__ import annotations

import copyreg
import io
import pickle
from typing import Any, TypeVar
from weakref import WeakValueDictionary

T = TypeVar("T")

_alive: WeakValueDictionary[int, Any] = WeakValueDictionary()


class _Pickler(pickle.Pickler):
    dispatch_table = copyreg.dispatch_table.copy()


def shared(kind: type[T]) -> type[T]:
    """Return the class. Decorate a class whose instances never change with it, so that forks share them."""
    _Pickler.dispatch_table[kind] = _by_reference
    return kind


def fork(value: T) -> T:
    """Return an independent copy of anything that can be pickled."""
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(value)
    copy: T = pickle.loads(buffer.getbuffer())
    return copy


def _by_reference(value: Any) -> tuple[Any, ...]:
    _alive[id(value)] = value
    return _recall, (id(value),)


def _recall(key: int) -> Any:
    return _alive[key]
