"""A cell controller: announces items, asks for placements, has them executed and reports.

It keeps nothing that matters: stopped at any point and started again, it goes on where the planner and the bridge are.
Likewise the planner and the bridge may be restarted at any time.

    python3 cell_controller.py --connect tcp/127.0.0.1:7447 --cell cell-1 --session monday-1 mug bowl banana
"""

import argparse
import math
import sys
import uuid

from ppnpack.client import Announcement, Connection, ItemState, OutcomeKind, default_endpoint


def pack(cell, session_id, objects):
    """Packs the objects in one session; gives how many were placed."""
    cell.begin(session_id, least_state_number=cell.state().state_number)
    cell.announce(Announcement(item_id=f"item-{i}", object=name) for i, name in enumerate(objects))
    while (step := cell.next_step()).HasField("decision"):
        decision = step.decision
        # Where the cell is held, somebody resumes it, however long that takes.
        outcome = cell.carry_out(decision, within_s=math.inf)
        cell.report(decision, outcome)
        how = OutcomeKind.Name(outcome.kind).removeprefix("OUTCOME_KIND_").lower()
        print(f"step {decision.step}: {decision.item_id} ({decision.object}) {how}", flush=True)
    for reason in step.reasons:
        print(f"cannot be placed: {reason.item_id}: {reason.text}", flush=True)
    return sum(item.state == ItemState.ITEM_STATE_PACKED for item in cell.session().items)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    endpoint = default_endpoint()
    parser.add_argument("--connect", default=endpoint, help="a Zenoh router, or `ppnpack up`; PPNPACK_ENDPOINT is another default")
    parser.add_argument("--zenoh-config", help="a Zenoh configuration file instead, as for mutual TLS")
    parser.add_argument("--cell", default="cell-1")
    parser.add_argument("--session", default=None, help="names the session; give it again to go on with it")
    parser.add_argument("--patience", type=float, default=60.0, help="seconds that a service may be away")
    parser.add_argument("objects", nargs="+", help="objects of the planner's catalogue, in the order of arrival")
    arguments = parser.parse_args()
    with Connection(arguments.connect, zenoh_config=arguments.zenoh_config) as connection:
        cell = connection.cell(arguments.cell, patience_s=arguments.patience)
        packed = pack(cell, arguments.session or uuid.uuid4().hex, arguments.objects)
    print(f"packed {packed} of {len(arguments.objects)} items")
    return 0 if packed else 1


if __name__ == "__main__":
    sys.exit(main())
