"""Base class of all data that crosses process boundaries: immutable and strict, with one JSON form."""

from abc import ABC, abstractmethod

from pydantic import BaseModel, ConfigDict, ValidationError


class FrozenModel(BaseModel):
    """Frozen record. Unknown fields, NaN and infinities are rejected."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class RegisteredModels(ABC):
    """Annotation of a field that holds an instance of one of several models, which are registered at run time."""

    @abstractmethod
    def models(self) -> tuple[type[FrozenModel], ...]:
        """Return the models that are registered now."""


def first_problem(error: ValidationError) -> str:
    """Return field and message of the first problem, as `ego.speed_mps: Input should be a valid number`."""
    first = error.errors()[0]
    return f"{'.'.join(map(str, first['loc'])) or 'the whole'}: {first['msg']}"
