"""Quick replies: probable utterances of a passenger in this situation, one button each."""

from __future__ import annotations

from stucksolver.scene import Scene
from stucksolver.solver import Question, QuestionKind
from stucksolver.solver.state_machine.state import Executing, State
from stucksolver_passenger.api_types import QuickReply, QuickReplyKind

STOP_WORDS = "stop"
"""Utterance of the button Stop. The interpretation is a request to stay, in every situation."""
YES = QuickReply(does=QuickReplyKind.YES, label="Yes")
NO = QuickReply(does=QuickReplyKind.NO, label="No")


def _says(label: str, words: str | None = None) -> QuickReply:
    return QuickReply(does=QuickReplyKind.SAY, label=label, says=words or label)


WAIT = _says("Please wait")
ROUND = _says("Please go round it")
OVERTAKE = _says("Please overtake them")
BEHIND = _says("Stay behind them")
OTHER_WAY = _says("Please take another way")
PULL_OVER = _says("Please pull over")
DRIVE_ON = _says("Please drive on")
NEVER_MIND = _says("Never mind, stop that")
ALL = (WAIT, ROUND, OVERTAKE, BEHIND, OTHER_WAY, PULL_OVER, DRIVE_ON, NEVER_MIND)
NEAR_M = 45.0
"""Longitudinal distance within which objects get quick replies (m). Ours."""
MOVING_MPS = 0.5
"""Speed from which a vehicle counts as moving (m/s). Ours."""


def ready_answers(state: State, question: Question | None, scene: Scene | None) -> tuple[QuickReply, ...]:
    """Return the replies to the open question to the passenger, or else the requests that are possible now."""
    if question is not None and question.to == "passenger" and question.kind is not QuestionKind.ADVICE:
        return (YES, NO)
    if isinstance(state.activity, Executing):
        return (NEVER_MIND,)
    ahead = () if scene is None else scene.in_path_ahead(NEAR_M)
    if not ahead:
        return (PULL_OVER,) if question is None else (WAIT, DRIVE_ON, OTHER_WAY)
    if ahead[0].speed_along_mps > MOVING_MPS:
        return (OVERTAKE, BEHIND)
    return (ROUND, WAIT, OTHER_WAY)
