"""The language-model reasoner: prompt, function call, strict parsing and one repair, within a deadline and a budget."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.reasoners.reasoner import OfferedPlan, ReasonerAnswer, ReasonerError, ReasonerRequest, ReasonerTrace
from stucksolver.reasoners.search.menu import MenuItem, plan_menu
from stucksolver.scene import Scene
from stucksolver_language.llm.answer_form import USUAL_FORM, AnswerForm
from stucksolver_language.llm.answer_parser import FORMAT, AnswerError, parse_answer
from stucksolver_language.llm.capabilities import ServerCapabilities
from stucksolver_language.llm.chat import (
    ChatModel,
    ChatReply,
    Finish,
    Message,
    PermanentReasonerError,
    Tool,
    TransientKind,
    TransientReasonerError,
    Usage,
)
from stucksolver_language.llm.model_families import MOST_TOKENS
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.plan_checks import checked_words
from stucksolver_language.llm.preflight import preflight_model
from stucksolver_language.llm.prompt import PROMPT_VERSION, messages
from stucksolver_language.llm.reply_selection import chosen
from stucksolver_language.llm.response_turns import cut_off_reason, recorded_prompt, response_turns
from stucksolver_language.llm.tool_schema import DECIDE, check_tool, decide_tool
from stucksolver_language.llm.usage_budget import (
    CHARACTERS_FOR_A_TOKEN,
    UsageLimits,
    cost_note,
    estimate,
    usage_limits_of,
)

FIRST_PAUSE_S = 0.25
"""Pause before the first retry (s). It doubles with each retry. Ours."""
EPISODE_PAUSE_S = 60.0
"""Time without a query after which a new budget begins (s). Ours."""
EPISODE_PROGRESS_M = 15.0
"""Progress after which a new budget begins (m): the distance that counts as a recovery."""


@dataclass(frozen=True)
class ModelSettings:
    """Limits of one decision."""

    deadline_s: float = 10.0
    """Wall time for one decision, with repairs and retries (s). A deadline in the request takes precedence."""
    repairs: int = 1
    """Number of invalid answers that are quoted to the model for repair. Ours."""
    checks: int = 2
    """Number of queries to the guard before the model must decide. Applies only if the request has a check. Ours."""


@dataclass
class _Query:
    """One decision in progress."""

    request: ReasonerRequest
    menu: tuple[MenuItem, ...] | None
    turns: list[Message]
    began: float
    limit_s: float
    checks_left: int
    repairs_left: int
    answers: list[str] = field(default_factory=list)
    usage: Usage | None = None
    model: str | None = None
    saw: bool = True
    """False if an image existed but was not sent."""
    notes_before: int = 0
    """Number of notes about the server when the query began."""

    @property
    def scene(self) -> Scene:
        return self.request.scene

    @property
    def plans(self) -> dict[str, RecoveryPlan]:
        return {item.letter: item.plan for item in self.menu or ()}

    @property
    def may_check(self) -> bool:
        return self.request.check is not None and self.checks_left > 0

    def add(self, usage: Usage) -> None:
        self.usage = usage if self.usage is None else self.usage + usage

    def left_s(self) -> float:
        return self.began + self.limit_s - time.monotonic()


class LanguageModelReasoner:
    """Turns any `ChatModel` into a reasoner.

    `decide` runs in the solver's worker thread, `cancel` in another thread.
    """

    def __init__(
        self,
        model: ChatModel,
        *,
        settings: ModelSettings | None = None,
        usage_limits: UsageLimits | None = None,
        form: AnswerForm | None = None,
    ) -> None:
        self.model = model
        self.form = form or _default_form(model)
        self.name = f"{model.name} (prompt {PROMPT_VERSION})"
        self.usage_limits = usage_limits or _default_limits(model)
        self._settings = settings or ModelSettings()
        self._cancelled = threading.Event()
        self._last: tuple[float, float | None] | None = None

    def preflight(self) -> tuple[str, ...]:
        """Check the model with one short query that counts toward no budget, as the solver requires before a drive."""
        notes = preflight_model(self.model, form=self.form)
        takes = self._takes()
        cost = None if takes is None else cost_note(self.usage_limits, takes.pictures, self.form.chain)
        return notes if cost is None else (*notes, f"{self.model.name} {cost}")

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Query the model, as in `Reasoner`. Without a deadline in the request, the one in the settings applies.

        Raises:
            ReasonerError: The answer was late, the budget is spent, or the answer is still invalid after repair.
        """
        scene = request.scene
        self._cancelled.clear()
        self._note_episode(scene)
        self.usage_limits.check(request.budget, scene.time_s)
        self._last = (scene.time_s, scene.ego.distance_to_destination_m)
        self.usage_limits.begin_query(scene.time_s)
        began = time.monotonic()
        menu = plan_menu(scene, request.assess) if self.form.menu and request.assess is not None else None
        query = _Query(
            request,
            menu,
            messages(scene, self.form, menu),
            began,
            self._settings.deadline_s if request.deadline_s is None else request.deadline_s,
            self._settings.checks,
            self._settings.repairs,
            notes_before=len(self._notes()),
        )
        first = list(query.turns)
        try:
            decision = self._run_query(query)
        except ReasonerError as error:
            error.trace = self._trace(query, first)
            raise
        return ReasonerAnswer(decision, self.name, self._trace(query, first))

    def cancel(self) -> None:
        """Cancel the running query. Any thread may call this."""
        self._cancelled.set()
        self.model.cancel()

    # ---- one decision

    def _run_query(self, query: _Query) -> Decision:
        while True:
            reply = self._ask(query)
            answer, asks = chosen(reply)
            query.answers.append(answer)
            if asks and query.may_check:
                self._answer_check(query, reply, answer)
                continue
            try:
                if asks:
                    raise AnswerError(f"call {DECIDE} now, with the whole answer")
                return parse_answer(answer, query.scene, query.plans)
            except AnswerError as error:
                cut_off = reply.finish is Finish.CUT_OFF
                self._repair(query, reply, AnswerError(cut_off_reason(reply)) if cut_off else error)

    def _ask(self, query: _Query) -> ChatReply:
        """Run one exchange. Retry after a pause if the failure may be temporary and the deadline allows it."""
        pause, broken = FIRST_PAUSE_S, False
        stated: TransientReasonerError | None = None
        tools = self._tools(query)
        must = DECIDE if len(tools) == 1 else None
        while True:
            if self._cancelled.is_set():
                raise PermanentReasonerError("the query was canceled")
            try:
                reply = self.model.chat(query.turns, tools, must, query.left_s())
            except TransientReasonerError as error:
                self._failed(query, tools, error)
                if broken and error.trouble is TransientKind.BROKEN:
                    raise ReasonerError(f"{error}; twice in a row") from error
                broken = error.trouble is TransientKind.BROKEN
                # What the server stated before says more than that the last attempt was late.
                stated = stated if stated is not None and error.trouble is TransientKind.LATE else error
                wait = max(pause, error.after_s or 0.0)
                if query.left_s() <= wait:
                    raise ReasonerError(f"{stated}; the deadline of {query.limit_s:g} s has passed") from error
                self._cancelled.wait(wait)
                pause *= 2
                continue
            except PermanentReasonerError as error:
                self._failed(query, tools, error)
                raise
            usage = reply.usage or estimate(query.turns, tools, len(reply.text) // CHARACTERS_FOR_A_TOKEN)
            self.usage_limits.add(usage)
            query.add(usage)
            query.model, query.saw = reply.model, reply.saw
            return reply

    def _failed(self, query: _Query, tools: list[Tool], error: TransientReasonerError | PermanentReasonerError) -> None:
        """Count a failed query that was sent: with the tokens that the server stated, or by estimate if it was late."""
        paid = error.paid if isinstance(error, PermanentReasonerError) else error.trouble is TransientKind.LATE
        usage = error.usage or (estimate(query.turns, tools, MOST_TOKENS) if paid else None)
        if usage is not None:
            query.add(usage)
            self.usage_limits.add(usage)

    def _trace(self, query: _Query, first: list[Message]) -> ReasonerTrace:
        return ReasonerTrace(
            format=FORMAT,
            prompt=recorded_prompt(first, query.saw),
            answers=tuple(query.answers),
            menu=tuple(OfferedPlan(letter=letter, plan=plan) for letter, plan in query.plans.items()),
            model=query.model or self.model.name,
            input_tokens=query.usage.input_tokens if query.usage else None,
            output_tokens=query.usage.output_tokens if query.usage else None,
            usd=self.usage_limits.price.cost_of(query.usage) if query.usage and self.usage_limits.price else None,
            seconds=round(time.monotonic() - query.began, 4),
            notes=tuple(self._notes()[query.notes_before :]),
        )

    def _takes(self) -> ServerCapabilities | None:
        takes = getattr(getattr(self.model, "inner", self.model), "takes", None)
        return takes if isinstance(takes, ServerCapabilities) else None

    def _notes(self) -> list[str]:
        takes = self._takes()
        return [] if takes is None else takes.notes

    def _tools(self, query: _Query) -> list[Tool]:
        tools = [decide_tool(query.scene, self.form)]
        if query.may_check:
            tools.append(check_tool(query.scene))
        return tools

    def _answer_check(self, query: _Query, reply: ChatReply, answer: str) -> None:
        query.checks_left -= 1
        self.usage_limits.refund_check()
        query.turns += response_turns(reply, checked_words(answer, query.request))

    def _repair(self, query: _Query, reply: ChatReply, error: AnswerError) -> None:
        """Quote the error to the model once. A second invalid answer is a failure."""
        if query.repairs_left == 0:
            raise ReasonerError(f"{self.model.name} gave an invalid answer: {error}") from error
        query.repairs_left -= 1
        self.usage_limits.check(query.request.budget)
        query.turns += response_turns(
            reply, f"That answer cannot be used: {error}. Answer again, complete and corrected."
        )

    def _note_episode(self, scene: Scene) -> None:
        """Start a new budget after 60 s without a query, or after 15 m of progress since the last query."""
        left, last = scene.ego.distance_to_destination_m, self._last
        if last is None:
            return
        progressed = left is not None and last[1] is not None and last[1] - left > EPISODE_PROGRESS_M
        if progressed or not 0 <= scene.time_s - last[0] <= EPISODE_PAUSE_S:
            self.usage_limits.new_episode()


def _options(model: ChatModel) -> ModelOptions | None:
    options = getattr(getattr(model, "inner", model), "options", None)
    return options if isinstance(options, ModelOptions) else None


def _default_form(model: ChatModel) -> AnswerForm:
    """Return the form that a model's own options state, or that of its recorded answers."""
    recorded = getattr(model, "form", None)
    if isinstance(recorded, AnswerForm):
        return recorded
    options = _options(model)
    return USUAL_FORM if options is None else options.form


def _default_limits(model: ChatModel) -> UsageLimits:
    """Return the limits that a model's own options state, with the price of its vendor."""
    inner: object = getattr(model, "inner", model)
    options = _options(model)
    if options is None:
        return UsageLimits(None)
    return usage_limits_of(getattr(inner, "model", ""), getattr(inner, "base_url", None), options)
