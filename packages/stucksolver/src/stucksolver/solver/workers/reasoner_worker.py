"""Queries a reasoner outside the control loop: one query at a time, in its own thread, with a deadline."""

from __future__ import annotations

import contextlib
import threading
import time
from concurrent.futures import Future

from stucksolver.guard import Approvals, Guard, RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan, apply_guidance_limits, intent_authorizes
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.reasoners import Cancellable, ReasonerAnswer, ReasonerError
from stucksolver.reasoners.reasoner import MalformedAnswerError, PlanCheck
from stucksolver.scene.bounded_values import MalformedError, read_again
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.plausibility import implausibility
from stucksolver.scene.wording import error_text, in_one_line
from stucksolver.solver.query import NoAnswer, Query
from stucksolver.solver.state_machine.admission import preview_verdict
from stucksolver.solver.state_machine.claims import CONFIRMS
from stucksolver.solver.state_machine.plan_preview import PlanPreview
from stucksolver.solver.workers.delivery_clock import WAIT_LIMIT_S, DeliveryClock, Pending
from stucksolver.solver.workers.reasoner_pool import MOST_VALUES, ReasonerPool


class ReasonerWorker:
    """Holder of the running query, if there is one.

    Its threads are daemons: a reasoner that never answers does not keep the process from ending.
    """

    def __init__(self, pool: ReasonerPool, guard: Guard, clock: DeliveryClock) -> None:
        self._pool = pool
        self._guard = guard
        self._clock = clock
        self._query: Query | None = None
        self._pending: Pending | None = None
        self._answer: Future[ReasonerAnswer] | None = None
        self._calls: dict[str, Future[ReasonerAnswer]] = {}
        """Last call by the ladder's name, including dropped ones. A reasoner never has two calls at once."""

    def work_on(self, query: Query | None) -> None:
        """Start this query, or none. A reasoner with another running query is canceled, if it supports that."""
        if query is self._query:
            return
        self._drop()
        if query is not None:
            self._begin(query)

    def at_work(self) -> frozenset[str]:
        """Return the reasoners whose last call has not returned, by their names in the ladder."""
        busy = {id(self._pool.reasoners[name]) for name, call in self._calls.items() if not call.done()}
        return frozenset(name for name, reasoner in self._pool.reasoners.items() if id(reasoner) in busy)

    def poll(self, now_s: float) -> ReasonerAnswer | NoAnswer | None:
        """Return the answer when the clock delivers it, and on every tick after that until the next query."""
        query, pending, answer = self._query, self._pending, self._answer
        if query is None or pending is None or answer is None:
            return None
        name = self._pool.names[query.reasoner]
        pending.ticks += 1
        if not self._clock.due(pending, now_s, answer):
            if now_s - query.asked_s <= query.deadline_s:
                return None
            return NoAnswer(f"{name} gave no answer within {query.deadline_s:g} s")
        if not answer.done():
            return NoAnswer(f"{name} hangs: no answer within {pending.wait_s:g} s of wall time")
        error = answer.exception()
        if error is None:
            return answer.result()
        if isinstance(error, ReasonerError):
            return NoAnswer(error_text(error), malformed=isinstance(error, MalformedAnswerError))
        return NoAnswer(f"{name} failed: {in_one_line(error)}")

    def _begin(self, query: Query) -> None:
        self._query = query
        # A simulated world waits as long as the reasoner may take and a little more, so that the reasoner can report
        # its reason for a missing answer.
        wait_s = max(WAIT_LIMIT_S, query.deadline_s + 5.0)
        self._pending = pending = Pending(query.asked_s, time.monotonic(), wait_s=wait_s)
        self._answer = self._calls[query.reasoner] = answer = Future[ReasonerAnswer]()
        work = (self._pool, query, self._check(query), self._assessor(query), pending, answer)
        threading.Thread(target=_think, args=work, name="stucksolver-reasoner", daemon=True).start()

    def _drop(self) -> None:
        """Drop the running query, and cancel the reasoner if it supports that."""
        query, answer = self._query, self._answer
        # The query is dropped first, so that an error of the reasoner cannot keep it.
        self._query = self._pending = self._answer = None
        if query is None or answer is None or answer.done():
            return
        reasoner: object = self._pool.reasoners[query.reasoner]
        with contextlib.suppress(Exception):  # Its answer is dropped anyway, whatever the reasoner raises.
            if isinstance(reasoner, Cancellable):
                reasoner.cancel()

    def _check(self, query: Query) -> PlanCheck | None:
        """Return a check with the guard's verdict on a plan at the time of the query, as text."""
        surroundings = query.seen
        if surroundings is None:
            return None

        def check(plan: RecoveryPlan) -> str:
            try:
                plan = read_again(plan, RecoveryPlan, MOST_VALUES)
            except MalformedError as error:
                return str(Verdict(rejects=(RejectReason(code=RejectCode.IMPLAUSIBLE, detail=str(error)),)))
            guided = intent_authorizes(query.reading, plan)
            limited = apply_guidance_limits(plan, query.reading)
            return preview_verdict(limited, FrenetScene(surroundings), query.asked_s, guard=self._guard, guided=guided)

        return check

    def _assessor(self, query: Query) -> PlanAssessor | None:
        """Return the guard's assessment of whole plans at the time of the query."""
        surroundings = query.seen
        if surroundings is None or implausibility(surroundings) is not None:
            return None
        view = FrenetScene(surroundings)
        confirmed = frozenset(CONFIRMS[claim] for claim in query.scene.claims if claim in CONFIRMS)
        approvals = Approvals(passenger=confirmed)
        return PlanPreview(self._guard, view, lambda plan: intent_authorizes(query.reading, plan), approvals).assess


def _think(
    pool: ReasonerPool,
    query: Query,
    check: PlanCheck | None,
    assess: PlanAssessor | None,
    pending: Pending,
    answer: Future[ReasonerAnswer],
) -> None:
    try:
        result = pool.consult(
            query.reasoner,
            query.scene,
            screen=query.screen,
            outlived=query.outlived,
            check=check,
            limit_s=query.deadline_s,
            assess=assess,
            budget=query.budget,
        )
    except BaseException as error:  # noqa: BLE001 - any error is stored for the control loop, which reports it
        pending.took_s = time.monotonic() - pending.asked_wall_s
        answer.set_exception(error)
    else:
        pending.took_s = time.monotonic() - pending.asked_wall_s
        answer.set_result(result)
