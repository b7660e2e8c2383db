"""Puts questions to reasoners: makes the scene, picks the reasoner, keeps the one question that is under way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from stucksolver.decision import WaitReason
from stucksolver.detect import Detector
from stucksolver.ladder import AskReasoner, Waits
from stucksolver.reason import Reasoner, ReasonerError
from stucksolver.reason.reasoner import PlanCheck
from stucksolver.scene import Guidance, PastAttempt, Scene, Status
from stucksolver.solver.camera import CameraWatch
from stucksolver.solver.clock import Clock
from stucksolver.solver.panel import Answer, Panel
from stucksolver.solver.thinking import Thinking


class Asking:
    """One question at a time. `scene` is the stack's; it may have none to give."""

    def __init__(
        self,
        scene: Callable[[], Scene | None],
        reasoners: Mapping[str, Reasoner],
        waits: Waits,
        clock: Clock,
        detector: Detector,
    ) -> None:
        self._scene = scene
        self._panel = Panel(reasoners, waits)
        self._detector = detector
        self._camera = CameraWatch()
        self.thinking = Thinking(clock)
        self.camera_fault: str | None = None

    @property
    def busy(self) -> bool:
        return self.thinking.busy

    @property
    def scene(self) -> Scene | None:
        """What the last question was about."""
        return self.thinking.scene

    def look(self) -> Scene | None:
        """The scene as the stack gives it now, without asking anybody about it."""
        return self._scene()

    def ask(
        self,
        move: AskReasoner,
        status: Status,
        words: Guidance | None,
        attempts: tuple[PastAttempt, ...],
        screen: bool,
        outlived: frozenset[WaitReason],
        check: PlanCheck | None = None,
    ) -> None:
        """Start a question; `status` is in the solver's own time. Raises `ReasonerError` where that cannot be."""
        try:
            scene = self._scene()
        except Exception as error:  # a stack's own fault, of whatever type, must not end the control loop
            raise ReasonerError(f"the stack's scene raised {type(error).__name__}: {error}") from error
        if scene is None:
            raise ReasonerError("the stack has no scene to give")
        scene, self.camera_fault = self._camera.checked(scene, status.progress_m)
        since = self._detector.slow_since_s
        ego = scene.ego.model_copy(
            update={
                "stopped_for_s": 0.0 if since is None else round(status.time_s - since, 2),
                "progress_20s_m": self._detector.progress_in_window_m,
            }
        )
        scene = scene.model_copy(update={"ego": ego, "guidance": words, "attempts": attempts})
        consult = partial(
            self._panel.consult,
            move.reasoner,
            screen=screen,
            outlived=outlived,
            check=check,
            limit_s=move.deadline_s,
        )
        reasoner = self._panel.reasoners[move.reasoner]
        self.thinking.ask(reasoner, consult, scene, status.time_s, move.deadline_s)

    def poll(self, now_s: float) -> Answer | None:
        """The answer when it is due. Raises `ReasonerError`."""
        return self.thinking.poll(now_s)

    def drop(self) -> None:
        self.thinking.drop()
