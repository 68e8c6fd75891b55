"""A robot of your own behind the bridge: what it does is one class, and the bridge that ships does all the rest.

    from ppnpack import robot
    from ppnpack.client import Connection

    class MyRobot(robot.Robot):
        def place(self, placement, is_given_up):
            ...  # Move. It returns when the robot has left the container.
            return robot.placed()

        def renew(self):
            ...  # Take the container away, and bring an empty one.

    with Connection("tcp/127.0.0.1:7447") as connection, robot.serve(connection, MyRobot()):
        input("Enter ends it")

The bridge has in its configuration `service.cells.cell-1.remote = {}` and a journal. It writes down what is asked for, holds the cell, counts
its states, and asks this program for one thing at a time, each at most once (proto/ppnpack/v1/robot.proto).
"""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import TimeoutError as StillRunning
from types import TracebackType
from typing import Any

import zenoh
from google.protobuf.message import DecodeError, Message

from ppnpack.client import Connection, Status
from ppnpack.client.requests import encoding_of
from ppnpack.v1 import bridge_pb2 as bridge
from ppnpack.v1 import robot_pb2 as wire
from ppnpack.v1.geometry_pb2 import Pose

# How much of a request's time is left to its answer.
_ANSWER_SHARE = 0.5
# How many requests are looked at together, and how many works are remembered: the bridge asks for the last alone.
_WAITING, _REMEMBERED = 8, 16


class Robot:
    """A robot; its methods are called one at a time. What one raises, the bridge takes for `unknown`: somebody has to look."""

    def take_over(self, bodies: list[bridge.Body]) -> Iterable[bridge.Body] | None:
        """What lies in the container, as far as the bridge knows. Gives what does, where the robot keeps account of it."""
        return None

    def place(self, placement: bridge.PlaceRequest, is_given_up: threading.Event) -> bridge.Outcome:
        """Places an item; gives how that ended, by the functions of this module. Once is_given_up is set, a robot that has not touched
        anything may end with not_placed."""
        raise NotImplementedError

    def renew(self) -> None:
        """Takes the container away, and brings an empty one. Raises where that did not happen."""
        raise NotImplementedError

    def bodies(self) -> Iterable[bridge.Body] | None:
        """What lies in the container after a placement; None: the bridge keeps account."""
        return None


def placed(found: Pose | None = None, *, is_inside: bool = True, slide_m: float = 0.0, tilt_rad: float = 0.0) -> bridge.Outcome:
    """The item was released in the container. found: its pose, where something looked (a camera, a simulation)."""
    return bridge.Outcome(
        kind=bridge.OUTCOME_KIND_PLACED,
        container_from_item=found,
        is_found=found is not None,
        is_inside=is_inside,
        slide_m=slide_m,
        tilt_rad=tilt_rad,
    )


def not_placed(failure: str) -> bridge.Outcome:
    """The item is where it was, and nothing in the container was changed."""
    return bridge.Outcome(kind=bridge.OUTCOME_KIND_NOT_PLACED, failure=failure)


def lost(failure: str) -> bridge.Outcome:
    """The item left the cell."""
    return bridge.Outcome(kind=bridge.OUTCOME_KIND_LOST, failure=failure)


def unknown(failure: str) -> bridge.Outcome:
    """Nobody knows how it ended: the container has to be seen again."""
    return bridge.Outcome(kind=bridge.OUTCOME_KIND_UNKNOWN, failure=failure)


class _Refusal(Exception):
    def __init__(self, status: Status, message: str) -> None:
        super().__init__(message)
        self.status = status


class _Work:
    """A placement or a renewal: what was asked for, and its end."""

    def __init__(self, asked: Message | None, end: Future[Any], is_given_up: threading.Event) -> None:
        self.asked, self.end, self.is_given_up = asked, end, is_given_up


class Server:
    """A robot that answers the bridge; made by serve. Ends with `with`, or by close."""

    def __init__(self, session: zenoh.Session, robot: Robot, cell: str) -> None:
        self._robot, self._start = robot, uuid.uuid4().hex
        self._works: dict[str, _Work] = {}
        self._lock = threading.Lock()
        self._moves, self._answers = ThreadPoolExecutor(1), ThreadPoolExecutor(_WAITING)
        self._methods: dict[str, tuple[type[Message], type[Message], Callable[[Any, Any], None]]] = {
            "take_over": (wire.TakeOverRequest, wire.TakeOverReply, self._take_over),
            "carry_out": (wire.CarryOutRequest, wire.CarryOutReply, self._carry_out),
            "bring_empty": (wire.BringEmptyRequest, wire.BringEmptyReply, self._bring_empty),
        }
        key = f"ppnpack/v1/{cell}/rpc/robot/*"
        self._queryable = session.declare_queryable(key, lambda query: self._answers.submit(self._answer, query), complete=True)

    def close(self) -> None:
        """Answers no more, and waits until the robot has ended what it does."""
        self._queryable.undeclare()  # type: ignore[no-untyped-call]
        self._moves.shutdown()
        self._answers.shutdown()

    def __enter__(self) -> Server:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            known = self._methods.get(str(query.key_expr).rsplit("/", 1)[1])
            if known is None:
                return
            request, reply, work = known[0](), known[1](), known[2]
            header = reply.header  # type: ignore[attr-defined]
            try:
                request.ParseFromString(query.payload.to_bytes() if query.payload else b"")
                header.request_id = request.header.request_id  # type: ignore[attr-defined]
                work(request, reply)
                header.status = Status.OK
            except DecodeError as error:
                header.status, header.message = Status.INVALID, str(error)
            except _Refusal as refusal:
                header.status, header.message = refusal.status, str(refusal)
            except Exception as error:  # What the robot's own code raises.
                header.status, header.message = Status.FAILED, f"{type(error).__name__}: {error}"
            query.reply(query.key_expr, reply.SerializeToString(), encoding=encoding_of(reply))

    def _take_over(self, request: wire.TakeOverRequest, reply: wire.TakeOverReply) -> None:
        with self._lock:
            self._must_be_idle()
            end = self._moves.submit(self._robot.take_over, list(request.bodies))
        tell(reply.bodies, end.result())
        reply.start = self._start

    def _carry_out(self, request: wire.CarryOutRequest, reply: wire.CarryOutReply) -> None:
        placement, is_given_up = request.placement, threading.Event()
        work = self._work(request.start, placement.placement_id, placement, lambda: self._place(placement, is_given_up), is_given_up)
        if request.is_given_up:
            work.is_given_up.set()
        if (ended := self._wait(work, request)) is not None:
            outcome, bodies = ended
            reply.outcome.CopyFrom(outcome)
            tell(reply.bodies, bodies)

    def _bring_empty(self, request: wire.BringEmptyRequest, reply: wire.BringEmptyReply) -> None:
        work = self._work(request.start, request.renewal_id, None, self._renew, threading.Event())
        if (failure := self._wait(work, request)) is not None:
            reply.has_ended, reply.failure = True, failure

    def _place(self, placement: bridge.PlaceRequest, is_given_up: threading.Event) -> tuple[bridge.Outcome, Iterable[bridge.Body] | None]:
        try:
            return self._robot.place(placement, is_given_up), self._robot.bodies()
        except Exception as error:
            return unknown(f"{type(error).__name__}: {error}"), None

    def _renew(self) -> str:
        try:
            self._robot.renew()
            return ""
        except Exception as error:
            return f"{type(error).__name__}: {error}"

    def _work(self, start: str, name: str, asked: Message | None, work: Callable[[], Any], is_given_up: threading.Event) -> _Work:
        """The work of this name: begun now, or before."""
        with self._lock:
            if start != self._start:
                raise _Refusal(Status.STALE, "the robot's program was started anew, and has to take over first")
            known = self._works.get(name)
            if known is None:
                self._must_be_idle()
                known = self._works[name] = _Work(asked, self._moves.submit(work), is_given_up)
                for oldest in list(self._works)[:-_REMEMBERED]:
                    del self._works[oldest]
            if known.asked != asked:
                raise _Refusal(Status.CONFLICT, f"{name} was asked for before with other content")
            return known

    def _must_be_idle(self) -> None:
        if not all(work.end.done() for work in self._works.values()):
            raise _Refusal(Status.BUSY, "the robot does something else")

    def _wait(self, work: _Work, request: wire.CarryOutRequest | wire.BringEmptyRequest) -> Any:
        try:
            return work.end.result(_ANSWER_SHARE * request.header.time_limit_us / 1e6)
        except StillRunning:
            return None


def tell(told: wire.Bodies, bodies: Iterable[bridge.Body] | None) -> None:
    if bodies is not None:
        told.SetInParent()
        told.bodies.extend(bodies)


def serve(connection: Connection, robot: Robot, cell: str = "cell-1") -> Server:
    """Has a robot answer the bridge of a cell, until it is closed."""
    return Server(connection.session, robot, cell)
