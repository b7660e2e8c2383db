"""The network that interprets utterances: word pieces from `tokenizers` and an encoder in onnxruntime, on one CPU core.

The weights are part of this package; nothing is downloaded. docs/words.md is the model card.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Sequence
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.interpretation import MOVES, REQUESTS, Claim, GuidanceIntent, Interpretation
from stucksolver.word_safeguards.calls_for_care import strip_caution
from stucksolver.word_safeguards.restraint import restrained
from stucksolver_language.intent.intent_decoder import ConfidenceThresholds, Numbers, read_fields
from stucksolver_language.intent.lexical_safeguards import is_meaningful_yes, is_stop_phrase, puts_off
from stucksolver_language.intent.quantities import Quantities, read_amounts
from stucksolver_language.intent.tokenization import encoded

DATA = Path(__file__).with_name("data")
THREADS = 1
"""Threads of onnxruntime. A second thread would spin while it waits, and slow down other work on the cores."""
LAWFUL_MPS = 50 / 3.6
"""Speed up to which no number alone makes a request unlawful (m/s): the usual limit in towns."""


class InterpreterError(RuntimeError):
    """The interpreter's files cannot be used. The message names the file and the remedy."""


class NetworkInterpreter:
    """Loads its weights at the first utterance (a third of a second).

    Each interpretation then takes some tens of ms.
    """

    def __init__(self, folder: Path = DATA, threads: int = THREADS) -> None:
        self._folder, self._threads = folder, threads
        self._lock = threading.Lock()

    @cached_property
    def card(self) -> dict[str, Any]:
        """Version, calibration and thresholds.

        Raises:
            InterpreterError: The card cannot be read.
        """
        try:
            card = json.loads((self._folder / "card.json").read_text(encoding="utf-8"))
            ConfidenceThresholds(**card["doubt"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InterpreterError(f"{self._folder / 'card.json'}: {error}; install stucksolver again") from error
        return dict(card)

    @property
    def name(self) -> str:
        """Name and version of the weights."""
        return f"words-{self.card['version']}"

    def read(self, text: str, situation: str) -> Interpretation:
        """Return the interpretation of `text`.

        Args:
            text: The passenger's utterance.
            situation: What the vehicle is doing, and its open question.

        Raises:
            InterpreterError: The weights cannot be loaded.
        """
        amounts = read_amounts(text)
        reading = self._read(text, situation)
        if amounts.rest not in ("", text) and (
            reading.intent is GuidanceIntent.UNCLEAR or _slow_enough(reading, amounts)
        ):
            # "Overtake them at 20 km/h" has the same intent as "overtake them", for which the network gives a
            # higher probability.
            shorter = self._read(amounts.rest, situation)
            reading = shorter if shorter.intent in REQUESTS else reading
        reading = restrained(reading, text)
        limited = reading.intent in REQUESTS or reading.intent is GuidanceIntent.WAIT
        return reading.model_copy(update={"limits": amounts.limits}) if limited else reading

    def _read(self, text: str, situation: str) -> Interpretation:
        if not text.strip():
            text = "..."
        request = strip_caution(text)
        if request is not None:
            reading = read_fields(self.logits(request, situation), self._doubt, self.name)
            if reading.intent in MOVES:
                return reading
        reading = read_fields(self.logits(text, situation), self._doubt, self.name)
        if reading.intent is GuidanceIntent.NO and Claim.RETURNING_SOON in reading.claims and puts_off(text):
            # "Wait, the driver is coming back" postpones an open question. As a no it would exclude the
            # plan permanently.
            return reading.model_copy(update={"intent": GuidanceIntent.WAIT})
        if reading.intent is GuidanceIntent.YES and not is_meaningful_yes(text):
            return reading.model_copy(update={"intent": GuidanceIntent.UNCLEAR})
        if reading.intent is GuidanceIntent.UNCLEAR and is_stop_phrase(text):
            return reading.model_copy(update={"intent": GuidanceIntent.WAIT})
        return reading

    def logits(self, text: str, situation: str) -> Numbers:
        """Return the network's output before calibration, (LOGITS,)."""
        with self._lock:
            tokenizer, table, scale, session = self._parts
            ids, kinds = encoded(tokenizer, situation, text)
            fed = {
                "vectors": unpacked(table, scale, ids)[None],
                "kinds": np.array([kinds], np.int64),
                "mask": np.ones((1, len(ids)), np.float32),
            }
            result: Numbers = session.run(None, fed)[0][0]
            return result

    @cached_property
    def _doubt(self) -> ConfidenceThresholds:
        return ConfidenceThresholds(**self.card["doubt"])

    @property
    def _parts(self) -> tuple[Any, Any, Any, Any]:
        return _loaded(self._folder, self._threads)


def _slow_enough(reading: Interpretation, amounts: Quantities) -> bool:
    """True if an utterance with a low speed was classified as unlawful.

    The network takes some numbers with km/h for speeding.
    """
    speed_mps = None if amounts.limits is None else amounts.limits.speed_mps
    return reading.intent is GuidanceIntent.UNLAWFUL and speed_mps is not None and speed_mps <= LAWFUL_MPS


@lru_cache(maxsize=2)
def _loaded(folder: Path, threads: int) -> tuple[Any, Any, Any, Any]:
    """Return the tokenizer, the vectors with their scales, and the network.

    All interpreters of a process share them.
    """
    import onnxruntime
    from tokenizers import Tokenizer

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        with np.load(folder / "pieces.npz") as pieces:
            table, scale = pieces["table"], pieces["scale"].astype(np.float32)
        tokenizer = Tokenizer.from_file(str(folder / "tokenizer.json"))
        session = onnxruntime.InferenceSession(
            str(folder / "encoder.onnx"), options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:
        raise InterpreterError(
            f"{folder}: the interpreter's weights cannot be loaded: {error}; install stucksolver again"
        ) from error
    return tokenizer, table, scale, session


def unpacked(table: NDArray[np.uint8], scale: Numbers, ids: Sequence[int] | NDArray[np.uint16]) -> Numbers:
    """Return the vectors of word pieces (pieces, width), from pairs of 4-bit numbers and one scale per block of a
    row.
    """
    pairs = table[ids].view(np.int8)
    # The low half of a byte comes first. Shifting it up and down again extends its sign.
    halves = np.stack((np.left_shift(pairs, 4) >> 4, pairs >> 4), axis=-1)
    blocks = halves.reshape(len(ids), scale.shape[1], -1)
    result: Numbers = (blocks * scale[ids][..., None]).reshape(len(ids), -1).astype(np.float32)
    return result
