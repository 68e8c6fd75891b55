"""A cell controller: announces items, asks for placements, has them executed and reports.

It keeps nothing that matters: stopped at any point and started again, it goes on where the planner and the bridge are.
Likewise the planner and the bridge may be restarted at any time.

    python3 cell_controller.py --connect tcp/127.0.0.1:7447 --cell cell-1 --session monday-1 mug bowl banana
"""

import argparse
import os
import sys
import time
import uuid

import zenoh

from ppnpack.v1 import bridge_pb2, header_pb2, planner_pb2

# Answers after which the same request may be sent again.
PASSING = (header_pb2.STATUS_BUSY, header_pb2.STATUS_TIMED_OUT, header_pb2.STATUS_UNAVAILABLE)


class Refused(Exception):
    """A request that was answered with a status other than STATUS_OK."""

    def __init__(self, header):
        super().__init__(f"{header_pb2.Status.Name(header.status)}: {header.message}")
        self.status = header.status


class Cell:
    """Sends requests to the services of one cell."""

    def __init__(self, session, name, patience_s):
        self.session, self.name, self.patience_s = session, name, patience_s
        # The packing session that requests are meant for: once another controller has begun another one they are refused.
        self.packing = ""

    def ask(self, service, method, request, reply_type, limit_s=5.0):
        """Sends a request until it is answered; the same request, so it must be safe to repeat: all of these are."""
        request.header.request_id = uuid.uuid4().hex
        request.header.session_id = self.packing
        request.header.time_limit_us = int(limit_s * 1e6)
        key = f"ppnpack/v1/{self.name}/rpc/{service}/{method}"
        give_up = time.monotonic() + self.patience_s
        while True:
            header = None
            payload = request.SerializeToString()
            for answer in self.session.get(key, payload=payload, timeout=limit_s + 0.5):
                if answer.ok is None:
                    continue
                reply = reply_type.FromString(answer.ok.payload.to_bytes())
                if reply.header.request_id != request.header.request_id:
                    continue
                if reply.header.status == header_pb2.STATUS_OK:
                    return reply
                header = reply.header
            if header is not None and header.status not in PASSING:
                raise Refused(header)
            if time.monotonic() > give_up:
                raise TimeoutError(f"{service} of {self.name}: {header.message if header else 'no answer'}")
            # No answer at all means that nobody serves the key just now, as during a restart.
            time.sleep(0.05)


def place(cell, decision):
    """Has the bridge carry a decision out; gives the outcome. Safe to repeat: it is executed once."""
    request = bridge_pb2.PlaceRequest(
        placement_id=decision.decision_id,
        item_id=decision.item_id,
        object=decision.object,
        container_from_item=decision.container_from_item,
        state_number=decision.state_number,
        # The motion that was checked, where the cell has an arm.
        cycle=decision.cycle if decision.HasField("cycle") else None,
        # A decision that is too old is refused as stale.
        decided_at_ns=decision.decided_at_ns,
    )
    without_outcome = {
        # The container is in another state than it was planned on: the placement was never begun.
        header_pb2.STATUS_STALE: bridge_pb2.OUTCOME_KIND_NOT_PLACED,
        # The bridge lost what it knew: the placement may have been carried out.
        header_pb2.STATUS_FORGOTTEN: bridge_pb2.OUTCOME_KIND_UNKNOWN,
    }
    while True:
        try:
            execution = cell.ask("bridge", "place", request, bridge_pb2.PlaceReply).execution
            break
        except Refused as refused:
            if refused.status == header_pb2.STATUS_HELD:
                # Until somebody resumes it, however long that takes.
                time.sleep(0.2)
                continue
            if refused.status not in without_outcome:
                raise
            kind, failure = without_outcome[refused.status], str(refused)
        state = cell.ask("bridge", "state", bridge_pb2.CellStateRequest(), bridge_pb2.CellStateReply).state
        return bridge_pb2.Outcome(kind=kind, failure=failure, state_number=state.state_number)
    while execution.phase != bridge_pb2.EXECUTION_PHASE_ENDED:
        request = bridge_pb2.OutcomeRequest(placement_id=decision.decision_id)
        execution = cell.ask("bridge", "outcome", request, bridge_pb2.OutcomeReply).execution
    return execution.outcome


def next_decision(cell):
    """The decision that awaits its outcome, or a new one; None when there is nothing left to do."""
    session = cell.ask("planner", "session", planner_pb2.SessionRequest(), planner_pb2.SessionReply).session
    if session.HasField("pending"):
        return session.pending
    try:
        reply = cell.ask("planner", "plan", planner_pb2.PlanRequest(), planner_pb2.PlanReply)
    except Refused as refused:
        if refused.status == header_pb2.STATUS_CONFLICT:
            # The answer to an earlier attempt was lost: its decision is in the session.
            return next_decision(cell)
        raise
    for reason in reply.reasons:
        print(f"cannot be placed: {reason.item_id}: {reason.text}", flush=True)
    return reply.decision if reply.result == planner_pb2.PLAN_RESULT_DECIDED else None


def pack(cell, session_id, objects):
    """Packs the objects in one session; gives how many were placed."""
    state = cell.ask("bridge", "state", bridge_pb2.CellStateRequest(), bridge_pb2.CellStateReply).state
    begin = planner_pb2.BeginRequest(session_id=session_id, least_state_number=state.state_number)
    cell.ask("planner", "begin", begin, planner_pb2.BeginReply)
    cell.packing = session_id
    items = [planner_pb2.Announcement(item_id=f"item-{i}", object=name) for i, name in enumerate(objects)]
    cell.ask("planner", "announce", planner_pb2.AnnounceRequest(items=items), planner_pb2.AnnounceReply)
    while (decision := next_decision(cell)) is not None:
        outcome = place(cell, decision)
        report = planner_pb2.ReportRequest(decision_id=decision.decision_id, outcome=outcome)
        cell.ask("planner", "report", report, planner_pb2.ReportReply)
        how = bridge_pb2.OutcomeKind.Name(outcome.kind).removeprefix("OUTCOME_KIND_").lower()
        print(f"step {decision.step}: {decision.item_id} ({decision.object}) {how}", flush=True)
    session = cell.ask("planner", "session", planner_pb2.SessionRequest(), planner_pb2.SessionReply).session
    return sum(item.state == planner_pb2.ITEM_STATE_PACKED for item in session.items)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    endpoint = os.environ.get("PPNPACK_ENDPOINT", "tcp/127.0.0.1:7447")
    parser.add_argument("--connect", default=endpoint, help="a Zenoh router, or `ppnpack up`; PPNPACK_ENDPOINT is another default")
    parser.add_argument("--zenoh-config", help="a Zenoh configuration file instead, as for mutual TLS")
    parser.add_argument("--cell", default="cell-1")
    parser.add_argument("--session", default=None, help="names the session; give it again to go on with it")
    parser.add_argument("--patience", type=float, default=60.0, help="seconds that a service may be away")
    parser.add_argument("objects", nargs="+", help="objects of the planner's catalogue, in the order of arrival")
    arguments = parser.parse_args()
    config = zenoh.Config.from_file(arguments.zenoh_config) if arguments.zenoh_config else zenoh.Config()
    if not arguments.zenoh_config:
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", f'["{arguments.connect}"]')
        config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        cell = Cell(session, arguments.cell, arguments.patience)
        packed = pack(cell, arguments.session or uuid.uuid4().hex, arguments.objects)
    print(f"packed {packed} of {len(arguments.objects)} items")
    return 0 if packed else 1


if __name__ == "__main__":
    sys.exit(main())
