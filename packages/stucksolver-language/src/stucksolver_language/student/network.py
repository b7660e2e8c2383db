"""The student's weights in onnxruntime, on the CPU, with the card that states their versions."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY
from stucksolver.scene.base_model import FrozenModel
from stucksolver_language.student import feature_encoding as features
from stucksolver_language.student import heads
from stucksolver_language.student import scene_codec as scene_text
from stucksolver_language.student.feature_encoding import EncodedScene, encode_plans
from stucksolver_language.student.heads import OUTPUTS, StudentOutput
from stucksolver_language.student.vocabulary import Vocabulary

DATA = Path(__file__).with_name("data")
WEIGHTS, CARD = "student.onnx", "student.json"
REMEDY = "train it again with `python -m lab distill train`, or install stucksolver again"


class StudentWeightsError(ValueError):
    """The student's weights cannot be used. The message says why and what to do."""


class Versions(FrozenModel):
    """Versions of all that the weights depend on."""

    scene_text: int
    features: int
    heads: int


class Card(FrozenModel):
    """Description of the weights, written by the training and checked before use.

    Attributes:
        name: Name of the model.
        versions: Versions during training.
        vocabulary: Behaviors and parameters of the training data. Other behaviors are not proposed.
        temperature: Divisor of the hazards' logits.
        sha256: Digest of the weights.
        trained: Data, command and seed of the training, for people.
        scores: Scores on held-out data, for people.
    """

    name: str
    versions: Versions
    vocabulary: Vocabulary
    temperature: float
    sha256: str
    trained: dict[str, Any]
    scores: dict[str, Any] = Field(default_factory=dict)


def versions() -> Versions:
    """Return the versions of this installation."""
    return Versions(scene_text=scene_text.VERSION, features=features.VERSION, heads=heads.VERSION)


def read_card(folder: Path) -> Card:
    """Return the card of a folder of weights, if they can be used here.

    Raises:
        StudentWeightsError: There is none, or it belongs to another version.
    """
    path = folder / CARD
    try:
        card = Card.model_validate_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise StudentWeightsError(f"no student in folder: {folder} has no {CARD}; {REMEDY}") from error
    except (OSError, ValidationError, UnicodeDecodeError) as error:
        raise StudentWeightsError(f"cannot read file: {path}: it is damaged or of another version; {REMEDY}") from error
    if card.versions != versions():
        raise StudentWeightsError(
            f"wrong version: {path} is for {_version_text(card.versions)}, "
            f"and this is {_version_text(versions())}; {REMEDY}"
        )
    gone = [name for name in card.vocabulary.behaviors if name not in REGISTRY]
    if gone:
        raise StudentWeightsError(f"unknown behaviors in file: {path}: {', '.join(gone)}; {REMEDY}")
    return card


def _version_text(item: Versions) -> str:
    return ", ".join(f"{name} {number}" for name, number in item.model_dump().items())


class StudentNetwork:
    """Answers scenes. Several threads may use it.

    Args:
        folder: Folder of the weights and their card.
        threads: Number of cores. More than one gives no speedup at this size.

    Raises:
        StudentWeightsError: The weights cannot be used.
    """

    def __init__(self, folder: Path = DATA, threads: int = 1) -> None:
        self.card = read_card(folder)
        self._session = _loaded(folder, self.card.sha256, threads)
        self._lock = threading.Lock()

    def answer(self, scene: EncodedScene, plans: Sequence[RecoveryPlan]) -> StudentOutput:
        """Return the calibrated outputs for one scene and its plans. The same input always gives the same output.

        Raises:
            KeyError: A plan has a behavior that is not in the card's vocabulary.
        """
        return self.run(scene, *encode_plans(plans, scene.ids, self.card.vocabulary))

    def run(self, scene: EncodedScene, rows: features.Floats, named: NDArray[np.int64]) -> StudentOutput:
        """Return the outputs for one scene and for plans that are already numbers, as from `encode_plans`."""
        if not len(rows):
            # The network's input needs at least one plan, so a row of zeros replaces an empty list.
            rows = np.zeros((1, *rows.shape[1:]), np.float32)
            named = np.full((1, *named.shape[1:]), features.MOST["objects"], np.int64)
        fed: dict[str, NDArray[Any]] = {kind: table[None] for kind, table in scene.rows.items()}
        fed |= {"mask": scene.mask[None], "plans": rows[None], "named": named[None]}
        with self._lock:
            found = self._session.run(list(OUTPUTS), fed)
        by_name = dict(zip(OUTPUTS, (item[0] for item in found), strict=True))
        by_name["hazard"] = by_name["hazard"] / np.float32(self.card.temperature)
        return StudentOutput(**by_name)


@lru_cache(maxsize=2)
def _loaded(folder: Path, sha256: str, threads: int) -> Any:
    """Return the session of a folder's weights. All reasoners of a process share it."""
    try:
        import onnxruntime
    except ImportError as error:
        raise StudentWeightsError("onnxruntime is not installed: add the extra [language] (README, Install)") from error
    try:
        data = (folder / WEIGHTS).read_bytes()
    except OSError as error:
        raise StudentWeightsError(
            f"no weights in folder: {folder} has no {WEIGHTS}: {error.strerror}; {REMEDY}"
        ) from error
    if hashlib.sha256(data).hexdigest() != sha256:
        raise StudentWeightsError(f"weights do not match their card: {folder / WEIGHTS} and {CARD}; {REMEDY}")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])


def card_text(card: Card) -> str:
    """Return the text of a card file."""
    return json.dumps(card.model_dump(mode="json"), indent=1) + "\n"
