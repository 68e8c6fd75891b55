"""Measures how long a stack of separate processes takes, as a controller sees it: to hold the cell, and to decide.

    cargo build --release --bins && python experiments/latency.py target/release

Needs eclipse-zenoh and protobuf, and the rights to mount a small disk. The stack has the defaults (built-in objects, 2.5 mm, 16 yaws, tries,
20 set aside) and a simulated cell. Two tables come out, for docs/results/stack.md.
"""

import argparse
import itertools
import json
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crates/python/python"))

from ppnpack.client import Announcement, ClientError, Connection, Status
from ppnpack.client.requests import attempt
from ppnpack.v1 import bridge_pb2 as bridge
from ppnpack.v1 import planner_pb2 as planner

CELL = "cell-1"
READY_WITHIN_S = 120.0
NEEDED = ["ppnpack", "ppnpack-router", "ppnpack-perception", "ppnpack-bridge", "ppnpack-planner"]


class Stack:
    """Router, perception, bridge and planner, each a process of its own, with their files in a folder."""

    def __init__(self, programs, folder, place_s):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.endpoint = f"tcp/127.0.0.1:{listener.getsockname()[1]}"
        own = {
            "router": [f'zenoh.listen=["{self.endpoint}"]'],
            "perception": [],
            "bridge": [f"service.journal={folder}/disk/journal.redb", f"service.cells={{{CELL}={{place_duration_s={place_s}}}}}"],
            "planner": [f"service.store={folder}/sessions.redb"],
        }
        self.processes = {}
        for name, settings in own.items():
            common = [] if name == "router" else [f'zenoh.connect=["{self.endpoint}"]']
            arguments = [part for setting in (*common, "admin.listen=127.0.0.1:0", *settings) for part in ("--set", setting)]
            with open(folder / f"{name}.log", "wb") as log:
                self.processes[name] = subprocess.Popen([programs / f"ppnpack-{name}", *arguments], stdout=log, stderr=log)

    def connect(self):
        end_s = time.monotonic() + READY_WITHIN_S
        while True:
            try:
                connection = Connection(self.endpoint)
                cell = connection.cell(CELL, limit_s=30.0, patience_s=READY_WITHIN_S)
                while not all(cell.health(service).is_ready for service in ("perception", "bridge", "planner")):
                    time.sleep(0.1)
                return connection, cell
            except ClientError:
                if time.monotonic() > end_s:
                    raise
                time.sleep(0.1)

    def close(self):
        for process in self.processes.values():
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()


def shown_ms(times_s):
    ordered = sorted(times_s)
    at = lambda share: 1e3 * ordered[round(share * (len(ordered) - 1))]
    return f"{len(ordered)} | {at(0.5):.1f} | {at(0.95):.1f} | {at(1.0):.1f}"


# Holds


def hold_once(connection):
    """How long one hold takes, and as what it is answered; the cell goes on afterwards."""
    key = f"ppnpack/v1/{CELL}/rpc/bridge/"
    request = bridge.HoldRequest(reason="measured", holder="latency")
    request.header.request_id, request.header.time_limit_us = uuid.uuid4().hex, 5_000_000
    began_s = time.perf_counter()
    reply = attempt(connection.session, f"{key}hold", request, bridge.HoldReply, 6.0)
    took_s = time.perf_counter() - began_s
    resume = bridge.ResumeRequest(hold_ids=[request.header.request_id])
    resume.header.request_id, resume.header.time_limit_us = uuid.uuid4().hex, 5_000_000
    attempt(connection.session, f"{key}resume", resume, bridge.ResumeReply, 6.0)
    return took_s, Status.of(reply.header.status) if reply else None


def holds(connection, name, count, accepted=(Status.OK,)):
    """A row: so many holds, with a pause between them."""
    measured = []
    for _ in range(count):
        measured.append(hold_once(connection))
        time.sleep(0.05)
    refused = sum(status not in accepted for _, status in measured)
    print(f"| {name} | {shown_ms([took_s for took_s, _ in measured])} | {refused} |", flush=True)


def ask_for_ever(endpoint, rate_hz, is_over):
    """Sends requests of all kinds at this rate, whatever becomes of them."""
    with Connection(endpoint) as connection:
        requests = [("bridge/state", bridge.CellStateRequest), ("planner/session", planner.SessionRequest)]
        requests += [("bridge/outcome", bridge.OutcomeRequest), ("bridge/changed", bridge.ChangedRequest)]
        for method, request_type in itertools.cycle(requests):
            if is_over.wait(1.0 / rate_hz):
                return
            request = request_type()
            request.header.request_id, request.header.time_limit_us = uuid.uuid4().hex, 1_000_000
            connection.session.get(f"ppnpack/v1/{CELL}/rpc/{method}", lambda _: None, payload=request.SerializeToString(), timeout=1.0)


def begin(connection, cell, count, is_automatic):
    """A session in an empty container, with objects of the built-in set in a random order."""
    names = list(OBJECTS)
    random.Random(count).shuffle(names)
    name = uuid.uuid4().hex
    if is_automatic:
        cell.resume()
    number = cell.renew()
    cell.begin(name, is_automatic=is_automatic, least_state_number=number, gives_up_pending=True)
    cell.announce([Announcement(item_id=f"{name[:8]}-{at}", object=names[at % len(names)]) for at in range(count)])


def measure_holds(stack, connection, cell, folder, count):
    print("| while | holds | median (ms) | 95 % | worst | refused |\n|---|---|---|---|---|---|")
    holds(connection, "nothing happens", count)
    begin(connection, cell, 200, is_automatic=True)
    holds(connection, "the automatic mode packs", count)
    cell.set_automatic(False)
    is_over = threading.Event()
    askers = [threading.Thread(target=ask_for_ever, args=(stack.endpoint, 250.0, is_over)) for _ in range(4)]
    for asker in askers:
        asker.start()
    holds(connection, "1,000 other requests a second come", count)
    is_over.set()
    for asker in askers:
        asker.join()
    host, port = stack.endpoint.removeprefix("tcp/").split(":")
    idle = []
    for _ in range(1000):
        try:
            idle.append(socket.create_connection((host, int(port)), timeout=5.0))
        except OSError:
            break
    holds(connection, f"{len(idle)} connections to the router do nothing", count)
    for one in idle:
        one.close()
    stack.processes["planner"].send_signal(signal.SIGSTOP)
    holds(connection, "the planner is stopped", count)
    stack.processes["planner"].send_signal(signal.SIGCONT)
    with open(folder / "disk/full", "wb", buffering=0) as full:
        try:
            while full.write(b"\0" * 65_536):
                pass
        except OSError:
            pass
    # It is held all the same, and says that a restart would forget it.
    holds(connection, "the bridge's disk is full", count, (Status.OK, Status.UNAVAILABLE))
    (folder / "disk/full").unlink()


# Decisions


def plan_once(connection, cell, limit_s):
    request = planner.PlanRequest()
    request.header.request_id, request.header.time_limit_us = uuid.uuid4().hex, int(limit_s * 1e6)
    request.header.session_id = cell.session_id
    began_s = time.perf_counter()
    reply = attempt(connection.session, f"ppnpack/v1/{CELL}/rpc/planner/plan", request, planner.PlanReply, limit_s + 10.0)
    return time.perf_counter() - began_s, reply


def decisions(connection, cell, limit_s, containers, count):
    """A row: plans of some containers, each with so long; without the wait for the picture."""
    times_s, answers = [], {"in time": 0, "decided": 0, "degraded": 0, "refused": 0}
    for _ in range(containers):
        begin(connection, cell, count, is_automatic=False)
        while True:
            cell.heightmap(least_state_number=cell.state().state_number)
            took_s, reply = plan_once(connection, cell, limit_s)
            times_s.append(took_s)
            answers["in time"] += took_s <= limit_s
            is_ok = reply is not None and Status.of(reply.header.status) is Status.OK
            answers["refused"] += not is_ok
            step = reply if is_ok else cell.next_step()
            if not step.HasField("decision"):
                break
            answers["decided"] += is_ok
            answers["degraded"] += is_ok and bool(step.decision.degraded)
            cell.report(step.decision, cell.carry_out(step.decision))
    share = lambda name: f"{100 * answers[name] / len(times_s):.1f} %"
    limit = "none" if limit_s > 10 else f"{1e3 * limit_s:.0f} ms"
    print(f"| {limit} | {shown_ms(times_s)} | {share('in time')} | {share('degraded')} | {share('refused')} |", flush=True)


def measure_decisions(connection, cell, containers, count):
    print("\n| limit | plans | median (ms) | 95 % | worst | in time | best so far, and said so | refused |\n|---|---|---|---|---|---|---|---|")
    for limit_s in (30.0, 0.3, 0.1):
        decisions(connection, cell, limit_s, containers, count)


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("programs", type=pathlib.Path, help="the folder of the programs")
parser.add_argument("--holds", type=int, default=200, help="holds a row [200]")
parser.add_argument("--containers", type=int, default=5, help="containers a row [5]")
parser.add_argument("--items", type=int, default=80, help="items that arrive for each [80]")
parser.add_argument("--place", type=float, default=0.0, help="how long a placement takes, in seconds [0]")
options = parser.parse_args()
if missing := [name for name in NEEDED if not (options.programs / name).is_file()]:
    parser.error(f"{options.programs} has no {', '.join(missing)}: cargo build --release --bins makes them")
listed = subprocess.run([options.programs / "ppnpack", "catalogue", "list", "--json"], capture_output=True, check=True)
OBJECTS = [listing["name"] for listing in json.loads(listed.stdout)]
with tempfile.TemporaryDirectory(prefix="ppnpack-latency-") as name:
    folder = pathlib.Path(name)
    (folder / "disk").mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", folder / "disk"], check=True)
    stack = Stack(options.programs, folder, options.place)
    try:
        connection, cell = stack.connect()
        with connection:
            measure_decisions(connection, cell, options.containers, options.items)
            measure_holds(stack, connection, cell, folder, options.holds)
    finally:
        stack.close()
        subprocess.run(["umount", folder / "disk"], check=True)
