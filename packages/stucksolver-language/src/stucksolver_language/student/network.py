"""The student's weights in onnxruntime, on the CPU, with the card that says for what they are."""

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
    """Versions of what the weights depend on."""

    scene_text: int
    features: int
    heads: int


class Card(FrozenModel):
    """What the weights are: written by the training, checked before they are used.

    Attributes:
        name: Name of the model.
        versions: Versions with which it was trained.
        vocabulary: Behaviours and parameters that it knows. Other behaviours are not proposed.
        temperature: The hazards' logits are divided by this.
        sha256: Digest of the weights.
        trained: How it was trained, for people: data, command, seed.
        scores: How it does on data that it has not seen, for people.
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
        WeightsError: There is none, or it belongs to another version.
    """
    path = folder / CARD
    try:
        card = Card.model_validate_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise StudentWeightsError(f"{folder} has no {CARD}: no student is there; {REMEDY}") from error
    except (OSError, ValidationError, UnicodeDecodeError) as error:
        raise StudentWeightsError(f"{path} cannot be read: it is damaged or of another version; {REMEDY}") from error
    if card.versions != versions():
        raise StudentWeightsError(f"{path} is for {_said(card.versions)}, and this is {_said(versions())}; {REMEDY}")
    gone = [name for name in card.vocabulary.behaviors if name not in REGISTRY]
    if gone:
        raise StudentWeightsError(f"{path} knows behaviours that do not exist here: {', '.join(gone)}; {REMEDY}")
    return card


def _said(item: Versions) -> str:
    return ", ".join(f"{name} {number}" for name, number in item.model_dump().items())


class StudentNetwork:
    """Answers scenes. May be used from several threads.

    Args:
        folder: Folder of the weights and their card.
        threads: Cores to use. More than one does not make it faster at this size.

    Raises:
        WeightsError: The weights cannot be used.
    """

    def __init__(self, folder: Path = DATA, threads: int = 1) -> None:
        self.card = read_card(folder)
        self._session = _loaded(folder, self.card.sha256, threads)
        self._lock = threading.Lock()

    def answer(self, scene: EncodedScene, plans: Sequence[RecoveryPlan]) -> StudentOutput:
        """Return the numbers for one scene and its plans; calibrated. The same input always gives the same output.

        Raises:
            KeyError: A plan has a behaviour that is not in the card's vocabulary.
        """
        return self.run(scene, *encode_plans(plans, scene.ids, self.card.vocabulary))

    def run(self, scene: EncodedScene, rows: features.Floats, named: NDArray[np.int64]) -> StudentOutput:
        """Return the numbers for one scene and plans that are numbers already, as `encode_plans` returns them."""
        if not len(rows):
            # The network's shape needs one plan; a row of zeros stands for none.
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
    """Return the session of a folder's weights: once for all reasoners of a process."""
    try:
        import onnxruntime
    except ImportError as error:
        raise StudentWeightsError("onnxruntime is not installed: add the extra [language] (README, Install)") from error
    try:
        data = (folder / WEIGHTS).read_bytes()
    except OSError as error:
        raise StudentWeightsError(f"{folder} has no {WEIGHTS}: {error.strerror}; {REMEDY}") from error
    if hashlib.sha256(data).hexdigest() != sha256:
        raise StudentWeightsError(f"{folder / WEIGHTS} is not the file of its card {CARD}; {REMEDY}")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])


def card_text(card: Card) -> str:
    """Return a card as it is written."""
    return json.dumps(card.model_dump(mode="json"), indent=1) + "\n"
