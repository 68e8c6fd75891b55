"""A client of the services over Zenoh: `pip install ppnpack[client]`. It is Python alone, and loads nothing of the engine.

    from ppnpack.client import Announcement, Connection

    with Connection("tcp/127.0.0.1:7447") as connection:
        cell = connection.cell("cell-1")
        cell.begin("monday-1", least_state_number=cell.state().state_number)
        cell.announce([Announcement(item_id="a", object="mug")])
        while (step := cell.next_step()).HasField("decision"):
            cell.report(step.decision, cell.carry_out(step.decision))

Each call is one request of the protocol (docs/protocol.md), and gives the service's message (ppnpack.v1); lengths are in metres, angles in
radians. It waits for the answer, and raises Refused with the service's status and words, or Unanswered when its time is up.
"""

try:
    import google.protobuf as _protobuf  # noqa: F401
    import zenoh as _zenoh  # noqa: F401
except ImportError as error:
    raise ImportError(f"{error}; ppnpack.client needs more: pip install ppnpack[client]") from error

from ppnpack.client.cell import Cell
from ppnpack.client.connection import Connection, default_endpoint
from ppnpack.client.errors import ClientError, Refused, Status, Unanswered, Unreachable
from ppnpack.client.heightmap import Heightmap
from ppnpack.client.streams import Stream
from ppnpack.v1.bridge_pb2 import CellState, Outcome, OutcomeKind
from ppnpack.v1.planner_pb2 import (
    Announcement,
    ContainerStart,
    Decision,
    ItemRules,
    ItemState,
    OrderLine,
    PlanReply,
    PlanResult,
    Region,
    Session,
)

__all__ = [
    "Announcement",
    "Cell",
    "CellState",
    "ClientError",
    "Connection",
    "ContainerStart",
    "Decision",
    "Heightmap",
    "ItemRules",
    "ItemState",
    "OrderLine",
    "Outcome",
    "OutcomeKind",
    "PlanReply",
    "PlanResult",
    "Refused",
    "Region",
    "Session",
    "Status",
    "Stream",
    "Unanswered",
    "Unreachable",
    "default_endpoint",
]
