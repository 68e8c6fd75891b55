"""The conformance kit passes the bridge that is shipped, and finds each of the things that bridges were seen to do wrong."""

import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import threading
import time
import uuid
from concurrent.futures import ThreadPoolExecutor

import pytest

pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")

from ppnpack import check_bridge, robot
from ppnpack.client import Connection, Decision, Status, Unreachable
from ppnpack.client.requests import attempt
from ppnpack.v1 import bridge_pb2 as bridge

# So long that requests come while the robot moves.
PLACE_S = 1.5
READY_WITHIN_S = 60.0
KIT = ["--object", "mug", "--at", "0.16,0.16,0.15", "--moves-the-robot", "--json"]


def free_port():
    """A port that clients do not get: while the bridge is away, one that connects again and again could connect to itself there."""
    while True:
        port = random.randrange(10_000, 30_000)
        try:
            socket.create_server(("127.0.0.1", port)).close()
            return port
        except OSError:
            continue


class Bridge:
    """The program `ppnpack-bridge`, which can be killed and started again."""

    def __init__(self, program, folder, cell=f"place_duration_s={PLACE_S}"):
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        settings = [
            "zenoh.mode=router",
            f'zenoh.listen=["{self.endpoint}"]',
            "admin.listen=127.0.0.1:0",
            f"service.cells={{cell-1={{{cell}}}}}",
            f"service.journal={folder / 'journal.redb'}",
        ]
        arguments = [part for setting in settings for part in ("--set", setting)]
        self.command, self.pid = [str(pathlib.Path(program).with_name("ppnpack-bridge")), *arguments], folder / "pid"

    def restart_command(self):
        """A command of the shell that kills it and starts it again, in the background.

        The second one starts when the first is gone: a process that is being killed still has its port and its journal.
        """
        quoted = " ".join(f"'{part}'" for part in self.command)
        gone = f"pid=$(cat '{self.pid}'); kill -9 $pid; while kill -0 $pid 2>/dev/null; do sleep 0.05; done"
        return f"{gone}; {quoted} >/dev/null 2>&1 & echo $! > '{self.pid}'"

    def __enter__(self):
        self.child = subprocess.Popen(self.command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.pid.write_text(str(self.child.pid))
        threading.Thread(target=self.child.wait, daemon=True).start()
        try:
            self.wait_ready(time.monotonic() + READY_WITHIN_S)
        except BaseException:
            self.__exit__()
            raise
        return self

    def wait_ready(self, end_s):
        while True:
            try:
                with Connection(self.endpoint) as connection:
                    connection.cell(patience_s=READY_WITHIN_S).state()
                    return
            except Unreachable:
                assert time.monotonic() < end_s and self.child.poll() is None
                time.sleep(0.1)

    def __exit__(self, *_):
        os.kill(int(self.pid.read_text()), signal.SIGKILL)
        self.child.wait()


@pytest.fixture(scope="module")
def started(program, tmp_path_factory):
    with Bridge(program, tmp_path_factory.mktemp("bridge")) as started:
        yield started


def results(started, capsys, *arguments):
    code = check_bridge.main(["--connect", started.endpoint, *KIT, *arguments])
    cases = {case["case"]: case for case in json.loads(capsys.readouterr().out)}
    assert (code == 0) == all(case["result"] == "right" for case in cases.values())
    return cases


def test_the_bridge_that_is_shipped_is_right(started, capsys):
    cases = results(started, capsys, "--restart", started.restart_command())
    assert len(cases) == 12
    assert [case for case in cases.values() if case["result"] != "right"] == []


class Unhurried(robot.Robot):
    """A robot in Python that keeps no account of what lies in the container."""

    def place(self, placement, is_given_up):
        if is_given_up.wait(PLACE_S):
            return robot.not_placed("nothing was touched")
        return robot.placed(placement.container_from_item)

    def renew(self):
        pass


def test_a_robot_in_python_behind_the_bridge_is_right(program, tmp_path, capsys):
    with Bridge(program, tmp_path, "remote={is_simulated=true}") as started, Connection(started.endpoint) as connection:
        with robot.serve(connection, Unhurried()):
            cases = results(started, capsys, "--restart", started.restart_command())
    assert [case for case in cases.values() if case["result"] != "right"] == []


def test_what_a_robot_raises_is_unknown_and_it_goes_on(program, tmp_path):
    class Breaks(robot.Robot):
        def place(self, placement, is_given_up):
            raise OSError("the gripper does not answer")

    with Bridge(program, tmp_path, "remote={is_simulated=true}") as started, Connection(started.endpoint) as connection:
        with robot.serve(connection, Breaks()):
            cell = connection.cell(patience_s=READY_WITHIN_S)
            for name in ("a", "b"):
                decision = Decision(decision_id=name, item_id=name, object="mug", state_number=cell.state().state_number)
                decision.container_from_item.CopyFrom(check_bridge.pose_at(0.1, 0.1, 0.1))
                cell.place(decision)
                outcome = cell.wait_for_outcome(decision)
                assert outcome.kind == bridge.OUTCOME_KIND_UNKNOWN and "the gripper does not answer" in outcome.failure
            request = bridge.RenewRequest(state_number=cell.state().state_number)
            request.header.request_id, request.header.time_limit_us = "renewal", 20_000_000
            key = "ppnpack/v1/cell-1/rpc/bridge/renew"
            header = attempt(connection.session, key, request, bridge.RenewReply, 30.0).header
            assert header.status == Status.FAILED and "NotImplementedError" in header.message


class Liar:
    """A bridge of another cell, which passes on to the true one what a lie makes of requests."""

    TYPES = {
        "place": (bridge.PlaceRequest, bridge.PlaceReply),
        "outcome": (bridge.OutcomeRequest, bridge.OutcomeReply),
        "renew": (bridge.RenewRequest, bridge.RenewReply),
        "hold": (bridge.HoldRequest, bridge.HoldReply),
        "resume": (bridge.ResumeRequest, bridge.ResumeReply),
        "changed": (bridge.ChangedRequest, bridge.ChangedReply),
        "state": (bridge.CellStateRequest, bridge.CellStateReply),
    }

    def __init__(self, session, lie):
        self.session, self.lie = session, lie
        self.answers = ThreadPoolExecutor(8)
        self.told = session.declare_subscriber("ppnpack/v1/cell-1/outcome", lambda told: session.put("ppnpack/v1/liar/outcome", told.payload))
        self.asked = session.declare_queryable("ppnpack/v1/liar/rpc/bridge/*", lambda query: self.answers.submit(self.answer, query))

    def ask(self, method, request):
        key, reply_type = f"ppnpack/v1/cell-1/rpc/bridge/{method}", self.TYPES[method][1]
        return attempt(self.session, key, request, reply_type, 30.0)

    def state(self):
        request = bridge.CellStateRequest()
        request.header.request_id, request.header.time_limit_us = uuid.uuid4().hex, 10_000_000
        return self.ask("state", request).state

    def answer(self, query):
        with query:
            method = str(query.key_expr).rsplit("/", 1)[1]
            request = self.TYPES[method][0].FromString(query.payload.to_bytes())
            request_id, request.header.cell = request.header.request_id, ""
            self.lie(self, method, request)
            reply = self.ask(method, request)
            reply.header.request_id = request_id
            query.reply(query.key_expr, reply.SerializeToString())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.asked.undeclare()
        self.told.undeclare()
        self.answers.shutdown()


def forgets_ids(_, method, request):
    """A placement that is sent again is another one, of whatever state the cell has."""
    if method == "place":
        request.placement_id = uuid.uuid4().hex


def believes_any_state(liar, method, request):
    """Placements are begun whatever they were planned on."""
    if method == "place":
        request.state_number = liar.state().state_number


def believes_any_time(_, method, request):
    """Placements are begun whenever they were decided."""
    if method == "place":
        request.decided_at_ns = 0


def mends_poses(_, method, request):
    """Poses that are none are taken for some place in the container."""
    if method == "place" and not check_bridge.is_pose(request.container_from_item):
        request.container_from_item.CopyFrom(check_bridge.pose_at(0.16, 0.16, 0.15))


def resumes_all(liar, method, request):
    """Any `resume` ends whatever holds the cell."""
    if method == "resume":
        request.hold_ids.extend(check_bridge.ids(liar.state()))


def goes_on_for_ever(_, method, request):
    """How many placements may begin is not counted."""
    if method == "resume":
        request.most_placements = 0


def renews_again(liar, method, request):
    """A renewal that is sent again is another one."""
    if method == "renew" and request.state_number:
        request.header.request_id, request.state_number = uuid.uuid4().hex, liar.state().state_number


@pytest.mark.parametrize(
    ("lie", "case"),
    [
        (forgets_ids, "places_once"),
        (believes_any_state, "refuses_other_states"),
        (believes_any_time, "refuses_old_decisions"),
        (mends_poses, "refuses_what_cannot_be"),
        (resumes_all, "holds"),
        (goes_on_for_ever, "goes_on_for_so_many"),
        (renews_again, "renews_once"),
    ],
)
def test_a_bridge_that_is_wrong_is_found_out(started, lie, case):
    options = check_bridge.read_options(["--cell", "liar", *KIT])
    with Connection(started.endpoint) as connection, Liar(connection.session, lie):
        kit = check_bridge.Kit(connection, options)
        kit.rest()
        with pytest.raises(check_bridge.Wrong):
            getattr(kit, case)()
        check_bridge.Kit(connection, check_bridge.read_options(KIT)).rest()


def test_it_moves_nothing_unless_it_is_told_to(capsys):
    with pytest.raises(SystemExit) as ended:
        check_bridge.main(["--object", "mug"])
    assert ended.value.code == 2 and "--moves-the-robot" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("bad", "named"),
    [(["--at", "nan,0,0"], "finite"), (["--at", "1,2"], "no point"), (["--patience", "nan"], "no time"), (["--patience", "-1"], "no time")],
)
def test_what_cannot_be_is_refused_before_anything_moves(bad, named, capsys):
    with pytest.raises(SystemExit) as ended:
        check_bridge.main([*KIT, *bad])
    assert ended.value.code == 2 and named in capsys.readouterr().err


def test_a_name_that_is_none_is_refused(started, capsys):
    assert check_bridge.main(["--connect", started.endpoint, "--cell", "A/B", *KIT]) == 2
    assert "A/B" in capsys.readouterr().err
