"""The figure of the cases: one row per case, with the camera image on the left and the reasoning on the right."""

from __future__ import annotations

import io
import textwrap
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from stucksolver.plan import Decision
from stucksolver_eval.cases.case_runner import CaseResult

IMAGE_W = 800
IMAGE_H = 450
TEXT_W = 860
MARGIN = 18
HEAD_H = 34
INK, GRAY, PAPER = (28, 30, 34), (108, 112, 120), (255, 255, 255)
SHADES = ((232, 240, 252), (252, 243, 226), (230, 245, 234))
COLUMNS = 104
"""Maximum number of characters in a line of text."""
LINE_H = 20


def draw_figure(results: list[CaseResult], path: Path) -> None:
    """Write a PNG that is 1,714 pixels wide. Raises `OSError`."""
    row_h = IMAGE_H + HEAD_H + 2 * MARGIN
    canvas = Image.new("RGB", (IMAGE_W + TEXT_W + 3 * MARGIN, row_h * len(results)), PAPER)
    for k, result in enumerate(results):
        _row(canvas, result, k * row_h)
    canvas.save(path, optimize=True)


def _row(canvas: Image.Image, result: CaseResult, top: int) -> None:
    draw = ImageDraw.Draw(canvas)
    draw.text((MARGIN, top + MARGIN - 6), result.case.title, INK, font=ImageFont.load_default(20))
    below = top + MARGIN + HEAD_H
    canvas.paste(_picture(result), (MARGIN, below))
    left, at = IMAGE_W + 2 * MARGIN, below
    for (title, lines), shade in zip(_chain(result), SHADES, strict=True):
        height = LINE_H * (len(lines) + 1) + 14
        draw.rounded_rectangle((left, at, left + TEXT_W, at + height), 8, shade)
        draw.text((left + 10, at + 5), title, INK, font=ImageFont.load_default(17))
        for i, line in enumerate(lines):
            draw.text((left + 10, at + 8 + LINE_H * (i + 1)), line, INK, font=ImageFont.load_default(15))
        at += height + 8
    draw.text((left + 10, at), f"Outcome: {result.ending}", GRAY, font=ImageFont.load_default(14))


def _picture(result: CaseResult) -> Image.Image:
    scene = result.decided.scene if result.decided is not None else None
    if scene is None or scene.image is None:
        empty = Image.new("RGB", (IMAGE_W, IMAGE_H), (226, 228, 232))
        ImageDraw.Draw(empty).text((IMAGE_W // 2 - 40, IMAGE_H // 2), "no picture", GRAY)
        return empty
    return Image.open(io.BytesIO(scene.image.jpeg)).convert("RGB").resize((IMAGE_W, IMAGE_H))


def _chain(result: CaseResult) -> list[tuple[str, list[str]]]:
    decision = result.decided.decision if result.decided is not None else None
    if decision is None:
        return [("1 Observe", ["no decision was made"]), ("2 Analyse", []), ("3 Decide", [])]
    utterance = result.case.words
    spoken = f' ("{utterance[1]}")' if utterance else ""
    return [
        ("1 Observe", _observed(decision)),
        (f"2 Analyse{spoken}", _analysed(decision)),
        ("3 Decide", _decided(result, decision)),
    ]


def _observed(decision: Decision) -> list[str]:
    observation = decision.observation
    lines = [
        f"{c.kind.value.replace('_', ' ')} {c.state.value if c.state else ''}"
        + (f", {c.distance_m:.0f} m" if c.distance_m is not None else "")
        for c in observation.controls[:2]
    ]
    for p in observation.participants[:4]:
        place = f", {p.distance_m:.1f} m" if p.distance_m is not None else ""
        lines.append(f"{p.kind.value} {p.object_id}, {p.lane.value} lane{place}: {p.intent.value.replace('_', ' ')}")
    return [line for text in [*lines, observation.summary] for line in textwrap.wrap(text, COLUMNS)][:7]


def _analysed(decision: Decision) -> list[str]:
    words = {True: "yes", False: "no", None: "unknown"}
    steps = [f"{s.id} {s.question} {words[s.answer]}: {s.evidence}" for s in decision.analysis.steps]
    return [line for text in [*steps, decision.analysis.reason] for line in textwrap.wrap(text, COLUMNS)][:8]


def _decided(result: CaseResult, decision: Decision) -> list[str]:
    event = result.decided
    if decision.plan is None:
        lines = ["None: wait" + (f" ({decision.analysis.wait.value})" if decision.analysis.wait else "")]
    else:
        lines = [str(b.model_dump_json(exclude_none=True)) for b in decision.plan.behaviors]
    if decision.plan is not None and event is not None and event.verdict is not None:
        lines.append(f"guard: {event.verdict}")
    return [line for text in [*lines, decision.rationale] for line in textwrap.wrap(text, COLUMNS)][:6]
