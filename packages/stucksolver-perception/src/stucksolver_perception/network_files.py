"""Loads trained networks from disk and checks them once, at start: a file of weights, and a card that describes it."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

DATA = Path(__file__).parent / "camera" / "data"
"""Folder of the weights and cards that ship with the package."""
REMEDY = "reinstall stucksolver, or train the network again and copy both files"
"""What a user can do about a broken file; the end of each message."""


class NetworkFileError(RuntimeError):
    """A network cannot be used. The message names the file, what is wrong with it, and the remedy."""


def load_card(card: Path, version: int) -> dict[str, Any]:
    """Read the card of a network.

    Args:
        card: A JSON file with at least `version` and `sha256` (of the weights).
        version: Version of the network's inputs and outputs that the code supports.

    Raises:
        NetworkFileError: The file is missing, is not a card, or has another version.
    """
    try:
        content = json.loads(card.read_text(encoding="utf-8"))
    except OSError as error:
        raise NetworkFileError(f"{card}: the network's card cannot be read ({error.strerror}); {REMEDY}") from error
    except ValueError as error:
        raise NetworkFileError(f"{card}: the network's card is damaged ({error}); {REMEDY}") from error
    if not isinstance(content, dict) or "sha256" not in content:
        raise NetworkFileError(f"{card}: the network's card is damaged (no checksum of its weights); {REMEDY}")
    if content.get("version") != version:
        raise NetworkFileError(
            f"{card}: the network has version {content.get('version')}; expected version {version}; {REMEDY}"
        )
    return content


def load_session(file: Path, card: Path, version: int, threads: int = 1) -> tuple[Any, dict[str, Any]]:
    """Load a network for the processor, with its card.

    Args:
        file: The weights, ONNX.
        card: See `load_card`.
        version: See `load_card`.
        threads: Number of threads per run.

    Returns:
        The `onnxruntime.InferenceSession` and the content of the card.

    Raises:
        NetworkFileError: A file is missing, damaged or has another version.
    """
    content = load_card(card, version)
    try:
        data = file.read_bytes()
    except OSError as error:
        raise NetworkFileError(f"{file}: the network's weights cannot be read ({error.strerror}); {REMEDY}") from error
    if hashlib.sha256(data).hexdigest() != content["sha256"]:
        raise NetworkFileError(f"{file}: the weights are damaged or not those of {card.name}; {REMEDY}")
    try:
        import onnxruntime
    except ImportError as error:
        raise NetworkFileError(
            f"{file}: the network requires onnxruntime; add the extra [perception] (README, Install)"
        ) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    options.log_severity_level = 3  # only errors
    try:
        return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"]), content
    except Exception as error:  # onnxruntime raises private types
        raise NetworkFileError(f"{file}: onnxruntime cannot load the weights ({error}); {REMEDY}") from error
