"""Swaps the sides in all texts of a report, for a vehicle in left-hand traffic, whose solver has a mirrored scene."""

from __future__ import annotations

from stucksolver.scene.mirror import with_sides_swapped
from stucksolver_passenger.api_types import ConversationLine, QuickReply, Speaker, VehicleReport


def report_with_sides_swapped(report: VehicleReport) -> VehicleReport:
    """Return a report whose texts name the sides as people see them. The words of people stay as they are."""
    question = report.question
    return report.model_copy(
        update={
            "thought": with_sides_swapped(report.thought),
            "intention": with_sides_swapped(report.intention),
            "question": question and question.model_copy(update={"text": with_sides_swapped(question.text)}),
            "answers": tuple(map(_answer, report.answers)),
            "lines": tuple(map(_line, report.lines)),
        }
    )


def _answer(answer: QuickReply) -> QuickReply:
    says = None if answer.says is None else with_sides_swapped(answer.says)
    return answer.model_copy(update={"label": with_sides_swapped(answer.label), "says": says})


def _line(line: ConversationLine) -> ConversationLine:
    text = with_sides_swapped(line.text) if line.speaker is Speaker.CAR else line.text
    understood = None if line.understood is None else with_sides_swapped(line.understood)
    return line.model_copy(update={"text": text, "understood": understood})
