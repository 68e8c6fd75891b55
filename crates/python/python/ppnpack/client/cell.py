"""A cell: its planner, bridge and perception."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import TypeVar

import zenoh

from ppnpack.client import requests
from ppnpack.client.errors import Refused, Status, Unanswered
from ppnpack.client.heightmap import Heightmap
from ppnpack.client.streams import Stream
from ppnpack.v1 import bridge_pb2 as bridge
from ppnpack.v1 import health_pb2 as health
from ppnpack.v1 import perception_pb2 as perception
from ppnpack.v1 import planner_pb2 as planner
from ppnpack.v1 import scene_pb2 as scene

R = TypeVar("R", bound=requests.Reply)

# How many plans and outcomes wait for a slow reader; of states, sessions and heightmaps the newest alone.
_KEPT = 64
_HELD_PAUSE_S = 0.2


class Cell:
    """Requests to the services of a cell, and its streams; made by Connection.cell.

    All requests wait for their answer, and are sent again under the same id while the service is busy or away, for patience_s at most. They
    raise Refused, with the status and the service's words, and Unanswered. What a service says comes as the message of proto/ppnpack/v1.

    session_id is the packing session that requests to the planner are meant for; begin sets it. Once another controller has begun another
    one they are refused (Status.CONFLICT).
    """

    def __init__(self, session: zenoh.Session, name: str, *, limit_s: float, patience_s: float) -> None:
        self.name = name
        self.limit_s = limit_s
        self.patience_s = patience_s
        self.session_id = ""
        self._session = session

    def ask(self, service: str, method: str, request: requests.Request, reply_type: type[R], *, container: str = "") -> R:
        """Any request of the protocol; the others of this class are made of it. container: one of a cell with several, at bridge and
        perception."""
        # In begin it would be the session that is to be replaced.
        if service == "planner" and method != "begin" and not request.header.session_id:
            request.header.session_id = self.session_id
        where = container or self.name
        limits = {"limit_s": self.limit_s, "patience_s": self.patience_s}
        return requests.ask(self._session, where, service, method, request, reply_type, **limits)

    # The session

    def begin(
        self,
        session_id: str,
        *,
        is_automatic: bool = False,
        keep_out: Iterable[planner.Region] = (),
        least_state_number: int = 0,
        set_aside: int | None = None,
        gives_up_pending: bool = False,
        containers: Iterable[planner.ContainerStart] = (),
        replaces: str = "",
    ) -> planner.Session:
        """Begins the packing of a container, or goes on with it where this session is under way. replaces: the session that is under way,
        where another one is not to be put away."""
        request = planner.BeginRequest(
            session_id=session_id,
            is_automatic=is_automatic,
            keep_out=list(keep_out),
            least_state_number=least_state_number,
            set_aside=set_aside,
            gives_up_pending=gives_up_pending,
            containers=list(containers),
        )
        request.header.session_id = replaces
        session = self.ask("planner", "begin", request, planner.BeginReply).session
        self.session_id = session_id
        return session

    def session(self) -> planner.Session:
        """The packing session, as it is on disk."""
        return self.ask("planner", "session", planner.SessionRequest(), planner.SessionReply).session

    def announce(self, items: Iterable[planner.Announcement]) -> planner.Session:
        """Items arrive, in this order. Those that were announced before are left as they are."""
        request = planner.AnnounceRequest(items=list(items))
        return self.ask("planner", "announce", request, planner.AnnounceReply).session

    def withdraw(self, item_id: str) -> planner.Session:
        """An item does not come."""
        return self.ask("planner", "withdraw", planner.WithdrawRequest(item_id=item_id), planner.WithdrawReply).session

    def withdraw_order(self, order: str) -> planner.Session:
        """Of this order no more items come than were announced so far."""
        return self.ask("planner", "withdraw", planner.WithdrawRequest(order=order), planner.WithdrawReply).session

    def set_automatic(self, is_automatic: bool, *, failure_id: str | None = None) -> planner.Session:
        """Switches the automatic mode; on: a failure is acknowledged. failure_id: that which was seen, by Session.failure_id; give it where
        somebody has looked. Without it, it is the one that the session has when this is called."""
        if failure_id is None:
            failure_id = self.session().failure_id if is_automatic else ""
        request = planner.AutomaticRequest(is_automatic=is_automatic, failure_id=failure_id)
        return self.ask("planner", "automatic", request, planner.AutomaticReply).session

    def open_container(
        self, sequence: int, *, container: str = "", keep_out: Iterable[planner.Region] = (), least_state_number: int = 0
    ) -> planner.Session:
        """An empty container stands where one was closed. sequence: which of those that stand there one after another, as in
        Session.containers."""
        start = planner.ContainerStart(container=container, keep_out=list(keep_out), least_state_number=least_state_number)
        request = planner.OpenRequest(start=start, sequence=sequence)
        return self.ask("planner", "open", request, planner.OpenReply).session

    def close_container(
        self, sequence: int, *, container: str = "", is_renewed: bool = False, text: str = ""
    ) -> planner.Session:
        """Nothing more is put into a container. is_renewed: the planner has an empty one brought, and opens it. text: why, for people."""
        request = planner.CloseRequest(container=container, sequence=sequence, is_renewed=is_renewed, text=text)
        return self.ask("planner", "close", request, planner.CloseReply).session

    # Steps

    def plan(self, *, alternatives: int = 0) -> planner.PlanReply:
        """Which item goes where: a decision, or why there is none (result, reasons). While a decision awaits its outcome that is
        Status.CONFLICT; next_step has it."""
        return self.ask("planner", "plan", planner.PlanRequest(alternatives=alternatives), planner.PlanReply)

    def next_step(self, *, alternatives: int = 0) -> planner.PlanReply:
        """The decision that awaits its outcome, as after a restart of the controller, or else a new plan."""
        if (pending := self._pending()) is not None:
            return pending
        try:
            return self.plan(alternatives=alternatives)
        except Refused as refused:
            # The answer to an earlier attempt was lost: its decision is in the session.
            if refused.status is Status.CONFLICT and (pending := self._pending()) is not None:
                return pending
            raise

    def _pending(self) -> planner.PlanReply | None:
        session = self.session()
        if not session.HasField("pending"):
            return None
        return planner.PlanReply(result=planner.PLAN_RESULT_DECIDED, decision=session.pending)

    def explain(self, item_id: str) -> planner.ExplainReply:
        """Where an item of the buffer would go, or why nowhere."""
        return self.ask("planner", "explain", planner.ExplainRequest(item_id=item_id), planner.ExplainReply)

    def report(self, decision: planner.Decision, outcome: bridge.Outcome) -> planner.Session:
        """Tells the planner how a decision was carried out: each, also that nothing was placed."""
        request = planner.ReportRequest(decision_id=decision.decision_id, outcome=outcome)
        return self.ask("planner", "report", request, planner.ReportReply).session

    # The robot

    def place(self, decision: planner.Decision) -> bridge.Execution:
        """Has the robot carry a decision out, at most once however often it is asked; says how far it is."""
        request = bridge.PlaceRequest(
            placement_id=decision.decision_id,
            item_id=decision.item_id,
            object=decision.object,
            container_from_item=decision.container_from_item,
            state_number=decision.state_number,
            cycle=decision.cycle if decision.HasField("cycle") else None,
            decided_at_ns=decision.decided_at_ns,
        )
        return self.ask("bridge", "place", request, bridge.PlaceReply, container=decision.container).execution

    def wait_for_outcome(self, decision: planner.Decision, *, within_s: float = 600.0) -> bridge.Outcome:
        """How its placement ended, once it has. Raises Unanswered where that takes longer than within_s."""
        end_s = time.monotonic() + within_s
        while True:
            request = bridge.OutcomeRequest(placement_id=decision.decision_id)
            execution = self.ask("bridge", "outcome", request, bridge.OutcomeReply, container=decision.container).execution
            if execution.phase == bridge.EXECUTION_PHASE_ENDED:
                return execution.outcome
            if time.monotonic() >= end_s:
                raise Unanswered(f"bridge/outcome of {decision.container or self.name}", within_s, None)

    def carry_out(self, decision: planner.Decision, *, within_s: float = 600.0) -> bridge.Outcome:
        """Places, and waits for the outcome; also that of a placement that can never be made, ready for report.

        A cell that is held is waited for. Raises Unanswered after within_s of that, or of the robot's work: ask again then, as nothing is
        done twice.
        """
        end_s = time.monotonic() + within_s
        while True:
            try:
                self.place(decision)
                return self.wait_for_outcome(decision, within_s=max(0.0, end_s - time.monotonic()))
            except Refused as refused:
                if refused.status is Status.STALE:
                    # The container is in another state than it was planned on: it was never begun.
                    return self._without_outcome(decision, bridge.OUTCOME_KIND_NOT_PLACED, refused)
                if refused.status is Status.FORGOTTEN:
                    # The bridge lost what it knew: it may have been carried out.
                    return self._without_outcome(decision, bridge.OUTCOME_KIND_UNKNOWN, refused)
                if refused.status is not Status.HELD:
                    raise
                if time.monotonic() >= end_s:
                    raise Unanswered(refused.request, within_s, refused) from refused
            time.sleep(_HELD_PAUSE_S)

    def _without_outcome(self, decision: planner.Decision, kind: bridge.OutcomeKind, refused: Refused) -> bridge.Outcome:
        state_number = self.state(container=decision.container).state_number
        return bridge.Outcome(kind=kind, failure=str(refused), state_number=state_number)

    def state(self, *, container: str = "") -> bridge.CellState:
        """The state of the cell, or of one of its containers."""
        return self.ask("bridge", "state", bridge.CellStateRequest(), bridge.CellStateReply, container=container).state

    def hold(self, reason: str, *, is_aborting: bool = False, holder: str = "", hold_id: str = "", container: str = "") -> bridge.CellState:
        """Nothing is begun any more until this and all other holds are ended. is_aborting: what is under way is broken off, where the robot
        can. holder: who holds, for people. hold_id: names it, for resume; one of its own for each hold. It is no safety-rated stop."""
        request = bridge.HoldRequest(reason=reason, is_aborting=is_aborting, holder=holder)
        request.header.request_id = hold_id
        return self.ask("bridge", "hold", request, bridge.HoldReply, container=container).state

    def resume(self, hold_ids: Iterable[str] | None = None, *, most_placements: int = 0, container: str = "") -> bridge.CellState:
        """Ends holds; the cell goes on when none is left. hold_ids: those that were seen, by CellState.holds; give them where a person
        resumes. Without them, they are all that hold the cell when this is called. most_placements: after so many it is held again; 0: it
        is not. Refused (Status.STALE) where it is held by others alone."""
        if hold_ids is None:
            state = self.state(container=container)
            if not state.holds:
                return state
            hold_ids = [hold.id for hold in state.holds]
        request = bridge.ResumeRequest(hold_ids=list(hold_ids), most_placements=most_placements)
        return self.ask("bridge", "resume", request, bridge.ResumeReply, container=container).state

    def changed(self, removed_item_ids: Iterable[str] = (), *, container: str = "") -> bridge.CellState:
        """Somebody had a hand in the container: it is seen anew, and what was planned before is stale."""
        request = bridge.ChangedRequest(removed_item_ids=list(removed_item_ids))
        return self.ask("bridge", "changed", request, bridge.ChangedReply, container=container).state

    def renew(self, *, request_id: str = "", state_number: int | None = None, container: str = "") -> int:
        """Has an empty container brought; gives its state number. request_id: makes this happen once, over restarts of the caller, too.
        state_number: the state whose content is to go, in place of the present one; where that has passed, it is refused (STALE)."""
        if state_number is None:
            state_number = self.state(container=container).state_number
        request = bridge.RenewRequest(state_number=state_number)
        request.header.request_id = request_id
        return self.ask("bridge", "renew", request, bridge.RenewReply, container=container).state_number

    # What is seen, and health

    def heightmap(self, *, least_state_number: int = 0, container: str = "") -> Heightmap:
        """The newest heightmap, of this state or a later one."""
        request = perception.HeightmapRequest(least_state_number=least_state_number)
        reply = self.ask("perception", "heightmap", request, perception.HeightmapReply, container=container)
        return Heightmap.of(reply.heightmap, reply.age_ns / 1e9)

    def health(self, service: str, *, container: str = "") -> health.HealthReply:
        """Whether a service is ready, each check by name."""
        return self.ask(service, "health", health.HealthRequest(), health.HealthReply, container=container)

    # Streams

    def plans(self) -> Stream[planner.Decision]:
        """Decisions, as they are made."""
        return Stream(self._session, self._key("plan"), planner.Decision.FromString, _KEPT)

    def sessions(self) -> Stream[planner.Session]:
        """The packing session, as it changes; the newest alone is kept."""
        return Stream(self._session, self._key("session"), planner.Session.FromString, 1)

    def outcomes(self, *, container: str = "") -> Stream[bridge.Outcome]:
        """How placements ended."""
        return Stream(self._session, self._key("outcome", container), bridge.Outcome.FromString, _KEPT)

    def states(self, *, container: str = "") -> Stream[bridge.CellState]:
        """States of the cell, on change and every few seconds; the newest alone is kept."""
        return Stream(self._session, self._key("state", container), bridge.CellState.FromString, 1)

    def heightmaps(self, *, container: str = "") -> Stream[Heightmap]:
        """Heightmaps, one for each cloud; the newest alone is kept."""
        name = container or self.name

        def read(message: bytes) -> Heightmap | None:
            heightmap = scene.Heightmap.FromString(message)
            # A network may mix keys up for a moment, as routers restart.
            return Heightmap.of(heightmap) if heightmap.cell in ("", name) else None

        return Stream(self._session, self._key("heightmap", container), read, 1)

    def _key(self, stream: str, container: str = "") -> str:
        return f"ppnpack/v1/{container or self.name}/{stream}"
