"""Requests are sent and repeated as docs/protocol.md says."""

import pathlib
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

from ppnpack.client import Connection, Heightmap, Refused, Status, Unanswered, Unreachable
from ppnpack.v1.header_pb2 import Status as WireStatus
from ppnpack.v1.planner_pb2 import PlanReply, PlanRequest
from ppnpack.v1.scene_pb2 import Heightmap as HeightmapMessage
from stack import Service

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
# More than the machine ever needs for one exchange, and no more than a test should take.
PATIENCE_S = 30.0


def reply_to(request, status=Status.OK, message="", request_id=None):
    reply = PlanReply()
    reply.header.request_id = request.header.request_id if request_id is None else request_id
    reply.header.status = int(status)
    reply.header.message = message
    return reply


def planning(*answers):
    """A planner whose answers to a request are, one after another, these statuses; the last one for ever. None: it does not answer."""

    def answer(request, count):
        status = answers[min(count, len(answers)) - 1]
        return [] if status is None else [reply_to(request, status, "in these words")]

    return Service("planner/plan", PlanRequest, answer)


def plan(service, patience_s=PATIENCE_S, **settings):
    with Connection(service.endpoint) as connection:
        cell = connection.cell("cell-1", patience_s=patience_s, **settings)
        cell.session_id = "monday-1"
        return cell.plan(alternatives=3)


@pytest.mark.parametrize("passing", [None, Status.BUSY, Status.TIMED_OUT, Status.UNAVAILABLE, Status.FAILED])
def test_a_request_keeps_its_id_when_it_is_repeated(passing):
    with planning(passing, Status.OK) as planner:
        plan(planner)
    first, again = planner.requests
    assert first.header.request_id == again.header.request_id != ""
    assert (again.alternatives, again.header.session_id, again.header.cell) == (3, "monday-1", "cell-1")
    assert 0 < first.header.time_limit_us <= 5_000_000


def test_each_new_request_has_a_new_id():
    with planning(Status.OK) as planner:
        plan(planner)
        plan(planner)
    first, second = planner.requests
    assert first.header.request_id != second.header.request_id


def test_a_busy_service_is_asked_at_growing_distances():
    with planning(Status.BUSY, Status.BUSY, Status.BUSY, Status.OK) as planner:
        plan(planner)
    pauses = np.diff(planner.times)
    assert len(pauses) == 3 and (pauses >= [0.05, 0.1, 0.2]).all(), pauses


def test_after_a_time_limit_the_service_is_given_more_time():
    with planning(Status.TIMED_OUT, Status.OK) as planner:
        plan(planner, limit_s=1.0)
    assert [request.header.time_limit_us for request in planner.requests] == [1_000_000, 2_000_000]


@pytest.mark.parametrize("status", [Status.INVALID, Status.NOT_FOUND, Status.STALE, Status.CONFLICT, Status.HELD, Status.FORGOTTEN])
def test_a_refusal_is_an_exception_with_the_services_words(status):
    with planning(status) as planner, pytest.raises(Refused, match=f"planner/plan of cell-1: {status.name}: in these words") as raised:
        plan(planner)
    assert raised.value.status is status and raised.value.message == "in these words"
    assert len(planner.requests) == 1


@pytest.mark.parametrize("number", [Status.FAILED, 0, 99])
def test_a_fault_of_the_service_is_tried_once_more(number):
    with planning(number) as planner, pytest.raises(Refused) as raised:
        plan(planner)
    assert raised.value.status is Status.FAILED
    assert len(planner.requests) == 2


def test_replies_to_other_requests_are_dropped():
    late = {"request_id": "an earlier one"}

    def answer(request, _):
        return [reply_to(request, Status.CONFLICT, **late), reply_to(request, message="mine"), reply_to(request, Status.FAILED, **late)]

    with Service("planner/plan", PlanRequest, answer) as planner:
        assert plan(planner).header.message == "mine"
    assert len(planner.requests) == 1


@pytest.mark.parametrize("answer", [None, Status.BUSY, Status.UNAVAILABLE])
def test_a_call_ends_when_its_time_is_up(answer):
    with planning(answer) as planner, pytest.raises(Unanswered) as raised:
        began = time.monotonic()
        plan(planner, patience_s=1.5)
    assert 1.0 < time.monotonic() - began < 10.0
    assert isinstance(raised.value, TimeoutError)
    assert raised.value.last is None if answer is None else raised.value.last.status is answer


def test_statuses_are_those_of_the_protocol():
    known = {f"STATUS_{status.name}": status.value for status in Status}
    assert known | {"STATUS_UNSPECIFIED": 0} == dict(WireStatus.items())


def test_nobody_at_an_endpoint_is_said():
    with planning(Status.OK) as planner:
        endpoint = planner.endpoint
    with pytest.raises(Unreachable, match=endpoint):
        Connection(endpoint)


def test_names_and_spans_that_cannot_be_are_refused():
    with planning(Status.OK) as planner, Connection(planner.endpoint) as connection:
        for name in ["", "all", "Cell", "a/b", "*", "x" * 65]:
            with pytest.raises(ValueError, match="no name of a cell"):
                connection.cell(name)
        for span_s in [0.0, -1.0, float("inf"), float("nan")]:
            with pytest.raises(ValueError, match="patience_s"):
                connection.cell(patience_s=span_s).plan()
    assert planner.requests == []


def heightmap(**changes):
    heights = np.arange(6, dtype="<i2")
    scene = {
        "grid": {"container": {"x_m": 0.3, "y_m": 0.2, "z_m": 0.1}, "cell_m": 0.1, "height_unit_m": 0.002},
        "heights": heights.tobytes(),
    }
    return HeightmapMessage(scene=scene | changes, state_number=7, quality={"doubts": [{"kind": 3, "message": "a hand"}]})


def test_a_heightmap_is_an_array():
    read = Heightmap.of(heightmap(surface={"samples_per_cell": 2, "heights_m": np.arange(24, dtype="<f4").tobytes()}))
    assert read.heights.dtype == np.int16 and read.heights.tolist() == [[0, 1], [2, 3], [4, 5]]
    assert read.heights_m[2, 1] == pytest.approx(0.01)
    assert read.surface_m.shape == (6, 4) and read.surface_m[0, 3] == 3
    assert (read.state_number, read.doubts) == (7, ("a hand",))


@pytest.mark.parametrize("changes", [{"heights": b"123"}, {"heights": bytes(10)}, {"grid": {}}, {"surface": {"samples_per_cell": 0}}])
def test_a_heightmap_whose_parts_do_not_fit_is_refused(changes):
    with pytest.raises(ValueError, match="a heightmap"):
        Heightmap.of(heightmap(**changes))


def test_the_messages_are_those_of_the_schemas(tmp_path):
    pytest.importorskip("grpc_tools", reason="grpcio-tools is not installed")
    script = REPOSITORY / "scripts" / "python-messages"
    subprocess.run([script, sys.executable, tmp_path], check=True, capture_output=True, timeout=120)
    committed = REPOSITORY / "crates" / "python" / "python" / "ppnpack" / "v1"
    made = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert made == {path.name: path.read_text() for path in committed.glob("*_pb2.py*")}, "run scripts/python-messages"


def test_the_client_loads_nothing_of_the_engine():
    check = "import sys, ppnpack.client; sys.exit('ppnpack._native' in sys.modules)"
    subprocess.run([sys.executable, "-c", check], check=True, timeout=60)
