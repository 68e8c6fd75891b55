"""The client against a stack of real services."""

import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
import uuid

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

from ppnpack.client import Announcement, Connection, ItemState, OutcomeKind, PlanResult, Refused, Status, Unanswered
from ppnpack.v1.bridge_pb2 import EXECUTION_PHASE_ENDED
from stack import Stack

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
CONTROLLER = REPOSITORY / "examples" / "python" / "cell_controller.py"
# More than anything takes on a machine that is busy with something else.
PATIENCE_S = 60.0


@pytest.fixture(scope="module")
def stack(program, tmp_path_factory):
    stack = Stack(program, tmp_path_factory.mktemp("stack") / "stack.log")
    yield stack
    stack.end()


@pytest.fixture(scope="module")
def connection(stack):
    with Connection(stack.endpoint) as connection:
        yield connection


@pytest.fixture
def cell(connection):
    """A cell with an empty container, and a session of its own."""
    cell = connection.cell("cell-1", patience_s=PATIENCE_S)
    cell.resume()
    cell.begin(uuid.uuid4().hex, least_state_number=cell.renew(), gives_up_pending=True)
    return cell


def announced(cell, *objects):
    return cell.announce(Announcement(item_id=f"{name}-{i}", object=name) for i, name in enumerate(objects))


def test_an_item_is_announced_planned_placed_and_reported(cell):
    with cell.plans() as plans, cell.outcomes() as outcomes:
        session = announced(cell, "mug")
        assert [(item.item_id, item.state) for item in session.items] == [("mug-0", ItemState.ITEM_STATE_WAITING)]
        step = cell.plan(alternatives=2)
        assert step.result == PlanResult.PLAN_RESULT_DECIDED and step.decision.item_id == "mug-0"
        assert step.decision.session_id == session.session_id == cell.session_id
        assert plans.receive(PATIENCE_S).decision_id == step.decision.decision_id

        assert cell.place(step.decision).placement_id == step.decision.decision_id
        outcome = cell.wait_for_outcome(step.decision, within_s=PATIENCE_S)
        assert outcome.kind == OutcomeKind.OUTCOME_KIND_PLACED
        assert outcomes.receive(PATIENCE_S) == outcome
        # Asked again, nothing is done twice.
        assert cell.place(step.decision).phase == EXECUTION_PHASE_ENDED
        assert cell.carry_out(step.decision) == outcome

    session = cell.report(step.decision, outcome)
    assert [item.state for item in session.items] == [ItemState.ITEM_STATE_PACKED]
    assert cell.session() == session
    assert [body.item_id for body in cell.state().bodies] == ["mug-0"]
    assert cell.plan().result == PlanResult.PLAN_RESULT_NOTHING_WAITS


def test_heightmaps_are_arrays(cell):
    empty = cell.heightmap(least_state_number=cell.state().state_number)
    assert empty.heights.shape == (16, 16) and empty.heights.max() == 0 and empty.age_s >= 0
    announced(cell, "mug")
    decision = cell.next_step().decision
    with cell.heightmaps() as heightmaps, cell.states() as states, cell.sessions() as sessions:
        outcome = cell.carry_out(decision)
        cell.report(decision, outcome)
        until(states, lambda state: state.state_number >= outcome.state_number)
        until(sessions, lambda session: session.step == 1 and not session.HasField("pending"))
        streamed = until(heightmaps, lambda heightmap: heightmap.state_number >= outcome.state_number)
    full = cell.heightmap(least_state_number=outcome.state_number)
    assert np.array_equal(full.heights, streamed.heights)
    # A mug is about a decimetre high.
    assert 0.05 < full.heights_m.max() < 0.2


def until(stream, holds):
    end_s = time.monotonic() + PATIENCE_S
    while not holds(message := stream.receive(end_s - time.monotonic())):
        pass
    return message


@pytest.mark.parametrize("closes", ["stream", "connection"])
def test_a_stream_that_is_closed_ends_its_reader(stack, closes):
    connection = Connection(stack.endpoint)
    stream = connection.cell().plans()
    read = []
    reader = threading.Thread(target=lambda: read.extend(stream))
    reader.start()
    {"stream": stream, "connection": connection}[closes].close()
    reader.join(PATIENCE_S)
    assert not reader.is_alive() and read == []
    with pytest.raises(ValueError, match="closed"):
        stream.receive(1.0)
    connection.close()


def test_a_stream_with_nothing_to_tell_says_so(cell):
    with cell.plans() as plans, pytest.raises(TimeoutError, match="plan: nothing within 0.1 s"):
        plans.receive(0.1)


def test_what_the_planner_refuses_is_an_exception_with_its_words(cell):
    with pytest.raises(Refused, match="unicorn") as raised:
        announced(cell, "unicorn")
    assert raised.value.status in (Status.INVALID, Status.NOT_FOUND) and "unicorn" in raised.value.message


def test_the_decision_that_awaits_its_outcome_is_the_next_step(cell):
    announced(cell, "mug", "banana")
    step = cell.plan()
    with pytest.raises(Refused) as raised:
        cell.plan()
    assert raised.value.status is Status.CONFLICT
    pending = cell.next_step().decision
    assert (pending.decision_id, pending.placement) == (step.decision.decision_id, step.decision.placement)


def test_a_controller_hears_that_another_one_has_begun(connection, cell):
    announced(cell, "mug")
    other = connection.cell("cell-1", patience_s=PATIENCE_S)
    other.begin(uuid.uuid4().hex)
    with pytest.raises(Refused) as raised:
        cell.next_step()
    assert raised.value.status is Status.CONFLICT
    assert other.next_step().result == PlanResult.PLAN_RESULT_NOTHING_WAITS


def test_a_cell_that_is_held_is_waited_for(cell):
    announced(cell, "mug")
    decision = cell.next_step().decision
    assert cell.hold("a door is open").hold.reason == "a door is open"
    with pytest.raises(Unanswered, match="a door is open") as raised:
        cell.carry_out(decision, within_s=0.5)
    assert raised.value.last.status is Status.HELD
    # Each ends what it saw alone, however often and late it is sent.
    cell.hold("a hand is in it", hold_id="hand")
    cell.resume(["hand"])
    with pytest.raises(Refused, match="a door is open") as raised:
        cell.resume(["hand"])
    assert raised.value.status is Status.STALE
    # The container may have changed meanwhile: what was decided before is never begun.
    cell.resume()
    assert not cell.resume(["hand"]).holds
    outcome = cell.carry_out(decision)
    assert outcome.kind == OutcomeKind.OUTCOME_KIND_NOT_PLACED and "STALE" in outcome.failure
    cell.report(decision, outcome)
    again = cell.next_step().decision
    assert again.decision_id != decision.decision_id
    assert cell.carry_out(again).kind == OutcomeKind.OUTCOME_KIND_PLACED


def test_an_item_is_explained_and_withdrawn(cell):
    announced(cell, "mug")
    assert cell.explain("mug-0").HasField("best")
    assert [item.state for item in cell.withdraw("mug-0").items] == [ItemState.ITEM_STATE_WITHDRAWN]
    with pytest.raises(Refused, match="explain of cell-1: CONFLICT: item mug-0"):
        cell.explain("mug-0")
    with pytest.raises(Refused, match="NOT_FOUND: .*mug-1"):
        cell.explain("mug-1")


def test_a_container_is_closed_and_an_empty_one_opened(cell):
    (before,) = cell.session().containers
    session = cell.close_container(before.sequence, text="it has to leave")
    assert [closed.text for closed in session.closed] == ["it has to leave"] and not session.containers[0].is_open
    (after,) = cell.open_container(before.sequence + 1, least_state_number=cell.renew()).containers
    assert after.is_open and after.sequence == before.sequence + 1


def test_a_changed_container_has_another_state(cell):
    before = cell.state().state_number
    assert cell.changed().state_number > before


def test_a_renewal_of_a_state_that_has_passed_takes_nothing_away(cell):
    before = cell.state().state_number
    cell.changed()
    with pytest.raises(Refused, match="STALE"):
        cell.renew(state_number=before)
    assert cell.renew(state_number=before + 1) > before + 1


def test_the_planner_packs_by_itself(cell):
    with cell.sessions() as sessions:
        cell.set_automatic(True)
        announced(cell, "mug", "banana")
        session = until(sessions, lambda session: session.end)
    assert [item.state for item in session.items] == [ItemState.ITEM_STATE_PACKED] * 2


@pytest.mark.parametrize("service", ["planner", "bridge", "perception"])
def test_a_service_says_that_it_is_ready(cell, service):
    assert cell.health(service).is_ready


def run_controller(stack, session):
    command = [sys.executable, CONTROLLER, "--connect", stack.endpoint, "--session", session, "mug", "bowl", "banana"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_the_example_packs_and_goes_on_where_it_was(cell, stack):
    session = uuid.uuid4().hex
    first = run_controller(stack, session)
    assert sum(line.startswith("step ") for line in first) == 3 and first[-1] == "packed 3 of 3 items"
    assert run_controller(stack, session) == ["packed 3 of 3 items"]


def test_the_documents_code_runs(cell, stack, monkeypatch):
    monkeypatch.setenv("PPNPACK_ENDPOINT", stack.endpoint)
    text = (REPOSITORY / "docs" / "python.md").read_text()
    blocks = [block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "ppnpack.client" in block]
    assert blocks
    for block in blocks:
        exec(compile(block, "python.md", "exec"), {})
    cell.session_id = ""
    assert [item.state for item in cell.session().items] == [ItemState.ITEM_STATE_PACKED] * 2


def test_a_stack_that_is_killed_ends_calls_in_time(program, tmp_path):
    stack = Stack(program, tmp_path / "stack.log")
    try:
        with Connection(stack.endpoint) as connection:
            cell = connection.cell("cell-1", patience_s=PATIENCE_S)
            cell.begin("killed", least_state_number=cell.state().state_number)
            announced(cell, "mug")
            decision = cell.next_step().decision
            stack.end(signal.SIGKILL)
            cell.patience_s = 2.0
            for call in [cell.session, cell.state, lambda: cell.carry_out(decision)]:
                began_s = time.monotonic()
                with pytest.raises(Unanswered, match="nobody answered"):
                    call()
                assert time.monotonic() - began_s < 10.0
    finally:
        stack.end(signal.SIGKILL)


def test_a_stack_that_stops_while_it_is_asked_ends_the_call_in_time(program, tmp_path):
    stack = Stack(program, tmp_path / "stack.log")
    try:
        with Connection(stack.endpoint) as connection:
            cell = connection.cell("cell-1", patience_s=PATIENCE_S)
            cell.state()
            # Its connections stay: nothing but the time that passes says that there is no answer.
            stack.process.send_signal(signal.SIGSTOP)
            cell.patience_s = 2.0
            began_s = time.monotonic()
            with pytest.raises(Unanswered):
                cell.state()
            assert 1.5 < time.monotonic() - began_s < 10.0
            stack.process.send_signal(signal.SIGCONT)
            cell.patience_s = PATIENCE_S
            cell.state()
    finally:
        stack.end(signal.SIGKILL)
