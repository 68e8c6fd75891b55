"""Drives the bridge of a cell through what goes wrong in cells, and says what it does wrong; for bridges in any language.

    python -m ppnpack.check_bridge --object mug --moves-the-robot
    python -m ppnpack.check_bridge --object mug --moves-the-robot --restart "systemctl restart my-bridge"

It asks as controllers and planners do (docs/protocol.md): late, twice, with other content, for past states, with numbers that are none.
Items are placed in the middle of the container: run it without items, and nobody in the cell. No planner may pack there meanwhile.

Exit codes: 0 all is right, 1 something is wrong or could not be decided, 2 wrong use, or no bridge.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable
from typing import Any, TypeVar

from google.protobuf.message import Message

from ppnpack.client import ClientError, Connection, Status, default_endpoint
from ppnpack.client.requests import Reply, Request, attempt
from ppnpack.v1 import bridge_pb2 as bridge
from ppnpack.v1.geometry_pb2 import Pose, Quaternion, Vector3

R = TypeVar("R", bound=Reply)

# How long an answer may take that waits for nothing, and one to a request to hold.
ANSWER_S, HOLD_S = 5.0, 0.5
# How many requests wait for an outcome while the cell is to be held.
WAITING = 64
HOUR_NS = 3_600 * 10**9
ENDED = bridge.EXECUTION_PHASE_ENDED


class Wrong(Exception):
    """The bridge does something that it must not."""


class Undecided(Exception):
    """Whether the bridge does it right does not show here, and why."""


def must(is_right: object, what: str) -> None:
    if not is_right:
        raise Wrong(what)


class Kit:
    """The cases, in the order in which they are run; each leaves the cell at rest, and held by nobody."""

    def __init__(self, connection: Connection, options: argparse.Namespace) -> None:
        self._connection, self._options = connection, options
        self._cell = connection.cell(options.cell, patience_s=options.patience)
        self._items = 0

    # Requests, each sent once

    def ask(self, method: str, request: Request, reply_type: type[R], limit_s: float = ANSWER_S) -> tuple[Status, R]:
        header = request.header
        header.request_id = header.request_id or uuid.uuid4().hex
        header.cell = header.cell or self._cell.name
        header.time_limit_us = int(limit_s * 1e6)
        key = f"ppnpack/v1/{self._cell.name}/rpc/bridge/{method}"
        reply = attempt(self._connection.session, key, request, reply_type, limit_s + 1.0)
        if reply is None:
            raise Wrong(f"{method} is not answered within {limit_s:g} s; a refusal is an answer, too, with the request's id in its header")
        return Status.of(reply.header.status), reply

    def state(self) -> bridge.CellState:
        status, reply = self.ask("state", bridge.CellStateRequest(), bridge.CellStateReply)
        must(status is Status.OK, f"state is refused as {status.name}: {reply.header.message}")
        return reply.state

    def placement(self, **changes: Any) -> bridge.PlaceRequest:
        """A placement of a new item, decided just now on the present state."""
        state, options = self.state(), self._options
        self._items += 1
        request = bridge.PlaceRequest(
            placement_id=uuid.uuid4().hex,
            item_id=f"check-{uuid.uuid4().hex[:8]}-{self._items}",
            object=options.object,
            container_from_item=pose_at(*options.at),
            state_number=state.state_number,
            decided_at_ns=state.clock_ns,
        )
        for name, value in changes.items():
            request.ClearField(name)
            if isinstance(value, Message):
                getattr(request, name).CopyFrom(value)
            elif value is not None:
                setattr(request, name, value)
        return request

    def place(self, request: bridge.PlaceRequest) -> tuple[Status, bridge.Execution]:
        again = bridge.PlaceRequest()
        again.CopyFrom(request)
        again.ClearField("header")
        status, reply = self.ask("place", again, bridge.PlaceReply)
        return status, reply.execution

    def begin(self) -> bridge.PlaceRequest:
        request = self.placement()
        status, reply = self.ask("place", request, bridge.PlaceReply)
        must(status is Status.OK, f"a placement on the present state is refused as {status.name}: {reply.header.message}")
        return request

    def outcome(self, placement_id: str, limit_s: float) -> tuple[Status, bridge.Execution]:
        request = bridge.OutcomeRequest(placement_id=placement_id)
        status, reply = self.ask("outcome", request, bridge.OutcomeReply, limit_s)
        return status, reply.execution

    def end_of(self, request: bridge.PlaceRequest) -> bridge.Outcome:
        end_s = time.monotonic() + self._options.patience
        while time.monotonic() < end_s:
            status, execution = self.outcome(request.placement_id, ANSWER_S)
            if status is Status.OK and execution.phase == ENDED:
                return execution.outcome
            waits = status in (Status.OK, Status.TIMED_OUT, Status.BUSY)
            must(waits, f"the outcome of a placement that is under way is refused as {status.name}")
        raise Wrong(f"a placement has no outcome within {self._options.patience:g} s")

    def hold(self, hold_id: str) -> bridge.HoldReply:
        request = bridge.HoldRequest(reason="the bridge is checked", holder="check")
        request.header.request_id = hold_id
        asked_s = time.monotonic()
        status, reply = self.ask("hold", request, bridge.HoldReply)
        took_s = time.monotonic() - asked_s
        must(status is Status.OK, f"a hold is refused as {status.name}: {reply.header.message}")
        must(took_s <= HOLD_S, f"a hold is answered after {took_s:.2f} s, and has to be within {HOLD_S:g} s, whatever the robot does")
        must(hold_id in ids(reply.state), "the state in the answer to a hold does not have it in `holds`")
        return reply

    def resume(self, *hold_ids: str, most_placements: int = 0) -> Status:
        request = bridge.ResumeRequest(hold_ids=list(hold_ids), most_placements=most_placements)
        return self.ask("resume", request, bridge.ResumeReply)[0]

    def renew(self, state_number: int, request_id: str) -> tuple[Status, bridge.RenewReply]:
        request = bridge.RenewRequest(state_number=state_number)
        request.header.request_id = request_id
        return self.ask("renew", request, bridge.RenewReply, self._options.patience)

    # What is looked at often

    def rest(self) -> None:
        """Ends the holds of this check, and waits until nothing is under way."""
        end_s = time.monotonic() + self._options.patience
        while time.monotonic() < end_s:
            state = self.state()
            if state.holds:
                self.resume(*ids(state))
            elif not state.executing_placement_id:
                return
            else:
                time.sleep(0.05)
        raise Wrong("the cell does not come to rest: it stays held or goes on with a placement")

    def must_refuse(self, request: bridge.PlaceRequest, *statuses: Status, why: str) -> None:
        before = self.state()
        status, _ = self.place(request)
        wanted = " or ".join(status.name for status in statuses)
        must(status in statuses, f"{why}: a placement is answered with {status.name}, and has to be refused as {wanted}")
        after = self.state()
        must(not after.executing_placement_id and len(after.bodies) == len(before.bodies), f"{why}: it is refused, and begun all the same")

    def waiting_hold(self) -> list[str]:
        """Holds the cell, with two ids."""
        names = [uuid.uuid4().hex, uuid.uuid4().hex]
        for name in names:
            must(self.hold(name).hold_id == name, "`hold_id` of a hold is another one than its request's id")
        return names

    # The cases

    def tells_its_state(self) -> None:
        first = self.state()
        must(first.state_number > 0, "state_number is 0: it stands for no state")
        must(0 < first.first_state_number <= first.state_number, "first_state_number is 0, or later than state_number")
        must(first.clock_ns > 0, "clock_ns is 0: planners cannot say when they decided, and late requests begin")
        time.sleep(0.1)
        passed_ns = self.state().clock_ns - first.clock_ns
        must(0.05e9 < passed_ns < 5e9, f"clock_ns went on by {passed_ns} ns while a tenth of a second passed")
        with self._cell.states() as states:
            try:
                told = states.receive(30.0)
            except TimeoutError:
                raise Wrong("nothing comes on the stream `state` within 30 s") from None
        must(told.state_number == first.state_number, "the stream `state` tells another state than the request for it")

    def places_once(self) -> None:
        before = self.state()
        with self._cell.outcomes() as outcomes:
            request = self.begin()
            outcome = self.end_of(request)
            try:
                told = outcomes.receive(10.0)
            except TimeoutError:
                raise Wrong("the outcome does not come on the stream `outcome`") from None
        must(told == outcome, "the stream `outcome` tells another outcome than the request for it")
        named = (outcome.placement_id, outcome.item_id) == (request.placement_id, request.item_id)
        must(named, "the outcome names another placement or item than was asked for")
        if outcome.kind != bridge.OUTCOME_KIND_PLACED:
            raise Undecided(f"the robot did not place: {bridge.OutcomeKind.Name(outcome.kind)}, {outcome.failure}")
        must(outcome.state_number > before.state_number, "a placed item does not count the state up")
        must(is_pose(outcome.container_from_item), "container_from_item of the outcome is no pose: finite, with a unit quaternion")
        after = self.state()
        must(after.state_number >= outcome.state_number, "the cell is in an earlier state than its last outcome says")
        must(any(body.item_id == request.item_id for body in after.bodies), "`bodies` lacks the item that was placed")
        self.must_know(request, outcome)
        status, _ = self.place(self.placement(item_id=request.item_id, placement_id=request.placement_id))
        must(status is Status.CONFLICT, f"a placement's id with other content is answered with {status.name}, not refused as CONFLICT")
        must(self.state().state_number == after.state_number, "a repeated request changed the state")

    def must_know(self, request: bridge.PlaceRequest, outcome: bridge.Outcome) -> None:
        before = self.state()
        status, execution = self.place(request)
        is_known = status is Status.OK and execution.phase == ENDED and execution.outcome == outcome
        must(is_known, f"a placement that has ended, sent again, is answered with {status.name} and not with its outcome")
        after = self.state()
        same = (before.state_number, len(before.bodies)) == (after.state_number, len(after.bodies))
        must(same and not after.executing_placement_id, "a placement that has ended, sent again, is carried out again")

    def answers_while_it_moves(self) -> None:
        first = self.begin()
        other = self.placement(decided_at_ns=None)
        status, _ = self.place(other)
        self.must_still_move(first)
        must(status is Status.BUSY, f"a second placement while the robot moves is answered with {status.name}, not refused as BUSY")
        status, _ = self.ask("changed", bridge.ChangedRequest(), bridge.ChangedReply)
        self.must_still_move(first)
        must(status is Status.BUSY, f"`changed` while the robot moves is answered with {status.name}, not refused as BUSY")
        asked_s = time.monotonic()
        status, execution = self.outcome(first.placement_id, 0.05)
        took_s = time.monotonic() - asked_s
        self.must_still_move(first)
        is_right = status is Status.TIMED_OUT or (status is Status.OK and execution.phase != ENDED)
        must(is_right and took_s < 1.0, f"an outcome with a limit of 50 ms is answered with {status.name} after {took_s:.2f} s")
        waiting = [threading.Thread(target=lambda: self.outcome_or_none(first), daemon=True) for _ in range(WAITING)]
        for thread in waiting:
            thread.start()
        time.sleep(0.2)
        self.hold(uuid.uuid4().hex)
        self.must_still_move(first)
        self.end_of(first)
        for thread in waiting:
            thread.join(self._options.patience)
        must(not any(thread.is_alive() for thread in waiting), "requests for an outcome are not answered when the placement has ended")
        self.must_refuse(other, Status.STALE, why="it was decided before the last placement")

    def outcome_or_none(self, request: bridge.PlaceRequest) -> None:
        try:
            self.outcome(request.placement_id, self._options.patience)
        except Wrong:
            pass

    def must_still_move(self, request: bridge.PlaceRequest) -> None:
        if self.state().executing_placement_id != request.placement_id:
            raise Undecided("the placement ended before the next request came: have it take two seconds")

    def refuses_other_states(self) -> None:
        state = self.state()
        for number, statuses, why in [
            (state.state_number - 1, (Status.STALE, Status.FORGOTTEN), "the state is past"),
            (state.state_number + 1, (Status.FORGOTTEN,), "no state was that late"),
            (state.first_state_number - 1, (Status.FORGOTTEN,), "the state is from before first_state_number"),
            (0, (Status.STALE, Status.INVALID), "0 is no state"),
        ]:
            self.must_refuse(self.placement(state_number=number), *statuses, why=why)

    def refuses_old_decisions(self) -> None:
        for apart_ns, why in [(-HOUR_NS, "it was decided an hour ago"), (HOUR_NS, "it was decided an hour from now, by another clock")]:
            before = self.state()
            request = self.placement(decided_at_ns=before.clock_ns + apart_ns)
            self.must_refuse(request, Status.STALE, why=why)
            must(self.state().state_number > before.state_number, f"{why}: the state has to count up, so that it never begins")
            self.must_refuse(request, Status.STALE, why=f"{why}, and is sent again")

    def refuses_what_cannot_be(self) -> None:
        x, y, z = self._options.at
        nan, infinite = pose_at(x, y, math.nan), pose_at(x, math.inf, z)
        turned, flat = pose_at(x, y, z), pose_at(x, y, z)
        turned.orientation.CopyFrom(Quaternion(w=2.0))
        flat.orientation.CopyFrom(Quaternion())
        impossible: list[tuple[dict[str, Any], str]] = [
            ({"placement_id": None}, "it has no placement_id"),
            ({"placement_id": "no id"}, "its placement_id has a blank"),
            ({"placement_id": "x" * 65}, "its placement_id is too long"),
            ({"item_id": None}, "it has no item_id"),
            ({"container_from_item": None}, "it has no pose"),
            ({"container_from_item": nan}, "its pose is no number"),
            ({"container_from_item": infinite}, "its pose is infinite"),
            ({"container_from_item": turned}, "its orientation is no unit quaternion"),
            ({"container_from_item": flat}, "its orientation is zero"),
            ({"container_from_item": pose_at(x + 10.0, y, z)}, "its pose is 10 m beside the container"),
            ({"container_from_item": pose_at(x, y, 9e5)}, "its pose is 900 km above the container"),
        ]
        for change, why in impossible:
            self.must_refuse(self.placement(**change), Status.INVALID, Status.NOT_FOUND, why=why)

    def refuses_what_is_no_request(self) -> None:
        elsewhere = bridge.CellStateRequest()
        elsewhere.header.cell = "another-cell"
        status, _ = self.ask("state", elsewhere, bridge.CellStateReply)
        must(status is Status.UNAVAILABLE, f"what is meant for another cell (header.cell) is answered with {status.name}, not UNAVAILABLE")
        status, _ = self.outcome(uuid.uuid4().hex, ANSWER_S)
        must(status is Status.NOT_FOUND, f"the outcome of a placement that never was is answered with {status.name}, not NOT_FOUND")
        self.hold(name := uuid.uuid4().hex)
        status = self.resume()
        must(status is Status.INVALID and name in ids(self.state()), f"`resume` without names is answered with {status.name}, not INVALID")
        self.rest()
        status, _ = self.renew(0, uuid.uuid4().hex)
        must(status is Status.INVALID, f"`renew` of state 0 is answered with {status.name}, not INVALID")
        key = f"ppnpack/v1/{self._cell.name}/rpc/bridge/place"
        for payload in (b"", b"\xff" * 64, b"\x00" * 100_000):
            for answer in self._connection.session.get(key, payload=payload, timeout=ANSWER_S):
                if answer.ok is not None:
                    status = Status.of(bridge.PlaceReply.FromString(answer.ok.payload.to_bytes()).header.status)
                    must(status is Status.INVALID, f"{len(payload)} bytes that are no request are answered with {status.name}")
        self.state()

    def holds(self) -> None:
        before = self.state().state_number
        first, second = self.waiting_hold()
        self.hold(first)
        must(ids(self.state()).count(first) == 1, "a hold that is sent again is a second one")
        refused = self.placement()
        self.must_refuse(refused, Status.HELD, why="the cell is held")
        status = self.resume(uuid.uuid4().hex)
        must(status is Status.STALE, f"`resume` of another hold than those there are is answered with {status.name}, not STALE")
        must(self.resume(first) is Status.OK, "`resume` of one of two holds is refused")
        must(ids(self.state()) == [second], "`resume` of one of two holds ends another one")
        status = self.resume(first)
        must(status is Status.STALE, f"a `resume` that comes twice is answered with {status.name}, not STALE, while others hold the cell")
        must(ids(self.state()) == [second], "a `resume` that comes twice ends a hold that it does not name")
        self.must_refuse(refused, Status.HELD, why="one of two holds is left")
        must(self.resume(second) is Status.OK, "`resume` of the last hold is refused")
        after = self.state()
        must(not after.holds and after.state_number > before, "the cell does not count its state up as it goes on")
        self.must_refuse(refused, Status.STALE, why="it was refused while the cell was held, and comes again")
        must(self.resume(second) is Status.OK, "`resume` in a cell that is not held is refused")
        self.hold(third := uuid.uuid4().hex)
        self.resume(first, second)
        must(ids(self.state()) == [third], "a late `resume` ends a hold that came after it")

    def goes_on_for_so_many(self) -> None:
        self.hold(name := uuid.uuid4().hex)
        must(self.resume(name, most_placements=1) is Status.OK, "`resume` with most_placements is refused")
        self.end_of(self.begin())
        must(self.state().holds, "after `resume` with most_placements = 1 one placement began, and the cell is not held again")
        self.must_refuse(self.placement(), Status.HELD, why="as many placements have begun as were asked for")

    def counts_changes(self) -> None:
        request = self.placement()
        before = self.state().state_number
        status, reply = self.ask("changed", bridge.ChangedRequest(), bridge.ChangedReply)
        must(status is Status.OK, f"`changed` is refused as {status.name}: {reply.header.message}")
        must(self.state().state_number > before, "`changed` does not count the state up")
        self.must_refuse(request, Status.STALE, why="somebody had a hand in the container since")

    def renews_once(self) -> None:
        before, name = self.state(), uuid.uuid4().hex
        status, _ = self.renew(before.state_number - 1, uuid.uuid4().hex)
        must(status is Status.STALE, f"`renew` of a past state is answered with {status.name}, not STALE")
        self.hold(hold := uuid.uuid4().hex)
        status, _ = self.renew(before.state_number, uuid.uuid4().hex)
        must(status is Status.HELD, f"`renew` in a cell that is held is answered with {status.name}, not HELD")
        self.resume(hold)
        number = self.state().state_number
        status, reply = self.renew(number, name)
        if status is not Status.OK:
            raise Undecided(f"no empty container is brought: {status.name}, {reply.header.message}")
        after = self.state()
        must(after.state_number >= reply.state_number > number, "a new container does not count the state up")
        must(not after.bodies, "`bodies` of a new container is not empty")
        status, again = self.renew(number, name)
        is_same = status is Status.OK and again.state_number == reply.state_number
        must(is_same and self.state().state_number == after.state_number, "a renewal that is sent again is carried out again")

    def remembers(self) -> None:
        """What ended before a restart, and while the robot moved."""
        ended = self.begin()
        outcome = self.end_of(ended)
        self.hold(name := uuid.uuid4().hex)
        before = self.state()
        self.restart()
        after = self.state()
        must(after.state_number >= before.state_number, "the state number went back over a restart")
        must(name in ids(after), "a hold is forgotten over a restart")
        status, execution = self.place(ended)
        known = status in (Status.FORGOTTEN, Status.STALE) or (status is Status.OK and execution.outcome.kind == outcome.kind)
        must(known, f"a placement from before a restart, sent again, is answered with {status.name}")
        self.rest()
        moving = self.begin()
        self.must_still_move(moving)
        self.restart()
        after = self.state()
        status, execution = self.outcome(moving.placement_id, ANSWER_S)
        is_open = status is Status.OK and execution.phase != ENDED and not after.executing_placement_id
        must(not is_open, "a placement that a restart cut off is said to be under way")
        must(after.is_simulated or after.holds, "a cell that is not simulated goes on after a restart amid a placement: it has to be held")
        self.rest()
        bodies = len(self.state().bodies)
        status, execution = self.place(moving)
        begins = status is Status.OK and execution.phase != ENDED
        must(not begins and len(self.state().bodies) <= bodies, "a placement that a restart cut off is begun a second time")

    def restart(self) -> None:
        subprocess.run(self._options.restart, shell=True, check=True)
        end_s = time.monotonic() + self._options.patience
        while True:
            try:
                self.state()
                return
            except Wrong:
                if time.monotonic() >= end_s:
                    raise Wrong(f"it does not serve again within {self._options.patience:g} s of a restart") from None


def ids(state: bridge.CellState) -> list[str]:
    return [hold.id for hold in state.holds]


def pose_at(x: float, y: float, z: float) -> Pose:
    return Pose(position=Vector3(x_m=x, y_m=y, z_m=z), orientation=Quaternion(w=1.0))


def is_pose(pose: Pose) -> bool:
    at, turn = pose.position, pose.orientation
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)
    return all(map(math.isfinite, (at.x_m, at.y_m, at.z_m, length))) and abs(length - 1.0) < 1e-3


def cases(kit: Kit, options: argparse.Namespace) -> list[tuple[str, Callable[[], None]]]:
    restart = [("remembers over a restart", kit.remembers)] if options.restart else []
    return [
        ("tells its state, and its clock", kit.tells_its_state),
        ("carries a placement out once", kit.places_once),
        ("answers while the robot moves", kit.answers_while_it_moves),
        ("refuses what was planned on another state", kit.refuses_other_states),
        ("refuses old decisions", kit.refuses_old_decisions),
        ("refuses placements that cannot be", kit.refuses_what_cannot_be),
        ("refuses what is no request", kit.refuses_what_is_no_request),
        ("holds until each hold is ended by its name", kit.holds),
        ("goes on for as many placements as are asked for", kit.goes_on_for_so_many),
        ("counts what people change", kit.counts_changes),
        ("brings a container once", kit.renews_once),
        *restart,
    ]


def run(kit: Kit, options: argparse.Namespace) -> list[dict[str, str]]:
    """What each case came to: right, wrong or undecided, and why."""
    results = []
    for name, case in cases(kit, options):
        result, why = "right", ""
        try:
            kit.rest()
            case()
            kit.rest()
        except Wrong as error:
            result, why = "wrong", str(error)
        except Undecided as error:
            result, why = "undecided", str(error)
        results.append({"case": name, "result": result, "why": why})
        if not options.json:
            print(f"{result:9}  {name}{': ' if why else ''}{why}", flush=True)
    return results


def point(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no point: give such as 0.16,0.16,0.1, in metres") from None
    if not all(map(math.isfinite, (x, y, z))):
        raise argparse.ArgumentTypeError(f"'{text}' is no point: its numbers have to be finite")
    return x, y, z


def seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is no time: give seconds above 0")
    return value


def read_options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m ppnpack.check_bridge", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    add = parser.add_argument
    add("--connect", default=default_endpoint(), metavar="ENDPOINT", help="a router, or the bridge itself [%(default)s]")
    add("--cell", default="cell-1", help="the cell whose bridge is checked [%(default)s]")
    add("--object", required=True, help="an object that the cell can place")
    add("--at", type=point, default=(0.16, 0.16, 0.1), metavar="X,Y,Z", help="where its frame is to be in the container, in metres [0.16,0.16,0.1]")
    add("--restart", metavar="COMMAND", help="a command that ends the bridge at once and starts it again: what it remembers is checked, too")
    add("--patience", type=seconds, default=120.0, metavar="SECONDS", help="how long a placement, a renewal or a restart may take [120]")
    add("--moves-the-robot", action="store_true", help="needed: it has items placed")
    add("--json", action="store_true", help="for programs: a list of cases")
    options = parser.parse_args(arguments)
    if not options.moves_the_robot:
        parser.error("it has items placed: see that nobody is in the cell, then give --moves-the-robot")
    return options


def main(arguments: list[str] | None = None) -> int:
    options = read_options(arguments)
    try:
        with Connection(options.connect) as connection:
            kit = Kit(connection, options)
            connection.cell(options.cell, patience_s=10.0).state()
            results = run(kit, options)
    except (ClientError, ValueError) as error:
        print(f"check_bridge: {error}", file=sys.stderr)
        return 2
    if options.json:
        print(json.dumps(results, indent=1))
    return 0 if all(result["result"] == "right" for result in results) else 1


if __name__ == "__main__":
    sys.exit(main())
