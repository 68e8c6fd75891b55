"""Real services as processes of their own, with a console."""

import json
import os
import pathlib
import signal
import socket
import subprocess
import threading
import time
import urllib.request

READY_WITHIN_S = 60.0
ENDED_WITHIN_S = 20.0
TOKEN = "of-the-browser-tests-only"


def free_port():
    """A port that the system chose a moment ago."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


class Process:
    """A program that can be killed and started again; its output is in a file."""

    def __init__(self, program, arguments, log, environment=None):
        self.command, self.log = [str(program), *arguments], log
        self.environment = os.environ | {"NO_COLOR": "1"} | (environment or {})
        self.child = None

    def start(self):
        with open(self.log, "ab") as log:
            self.child = subprocess.Popen(self.command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=self.environment)

    def end(self, how=signal.SIGTERM):
        if self.child is None:
            return
        if self.child.poll() is None:
            self.child.send_signal(how)
        try:
            self.child.wait(ENDED_WITHIN_S)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()
        self.child = None


class Stack:
    """Router, heuristic, perception, bridge, planner and console, on ports that the system chooses."""

    CELL = "cell-1"
    # So that there is something to interrupt.
    PLACE_DURATION_S = 0.5

    def __init__(self, programs, folder):
        self.programs, self.folder = programs, folder
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.url = f"http://127.0.0.1:{free_port()}/"
        listen = self.url.removeprefix("http://").rstrip("/")
        (folder / "token").write_text(TOKEN)
        own = {
            "router": [f'zenoh.listen=["{self.endpoint}"]'],
            "heuristic": [],
            "perception": [],
            "bridge": [f"service.cells={{{self.CELL}={{place_duration_s={self.PLACE_DURATION_S}}}}}"],
            "planner": [
                f"service.store={folder / 'sessions.redb'}",
                f'service.cells={{{self.CELL}={{alternatives=3,proposals={{from="all"}}}}}}',
            ],
            "console": [f"service.listen={listen}", f"service.token_file={folder / 'token'}"],
        }
        self.processes = {}
        for name, settings in own.items():
            common = [] if name == "router" else [f"instance={name}-1", f'zenoh.connect=["{self.endpoint}"]', "log.format=human"]
            arguments = [part for setting in (*common, "admin.listen=127.0.0.1:0", *settings) for part in ("--set", setting)]
            self.processes[name] = Process(programs / f"ppnpack-{name}", arguments, folder / f"{name}.log")

    def start(self):
        for process in self.processes.values():
            process.start()
        self.wait_ready()

    def end(self):
        for process in reversed(self.processes.values()):
            process.end()

    def state(self):
        """All parts as the console has them, by cell, container and name."""
        with urllib.request.urlopen(f"{self.url}api/state", timeout=5) as answer:
            parts = json.load(answer)["parts"]
        return {(part["cell"], part["container"], part["part"]): part["value"] for part in parts}

    def wait_rest(self):
        """Waits until the robot rests, and nothing is decided that it would do."""

        def rests():
            state = self.state()
            return state[(self.CELL, self.CELL, "state")]["executing"] is None and state[(self.CELL, None, "session")]["pending"] is None

        self.wait(rests, "the cell does not come to rest")

    def wait_ready(self):
        wanted = {"heuristic", "perception", "bridge", "planner"}

        def is_ready():
            services = self.state().get((None, None, "services"), [])
            return wanted <= {service["service"] for service in services if service["is_ready"]}

        self.wait(is_ready, "the services are not ready")

    def wait(self, is_so, otherwise):
        deadline = time.monotonic() + READY_WITHIN_S
        while time.monotonic() < deadline:
            try:
                if is_so():
                    return
            except OSError:
                pass
            ended = [name for name, process in self.processes.items() if process.child is None or process.child.poll() is not None]
            assert not ended, f"{ended} ended: {self.processes[ended[0]].log.read_text()}"
            time.sleep(0.1)
        raise AssertionError(f"{otherwise}; the logs are in {self.folder}")

    def call(self, service, method, **fields):
        """A request as any controller sends it; gives the reply."""
        return call(self.programs, self.endpoint, service, method, fields)

    def begin(self, name, objects):
        """Begins a session in an empty container, whatever was before."""
        holds = self.call("bridge", "state")["state"].get("holds", [])
        if holds:
            self.call("bridge", "resume", hold_ids=[hold["id"] for hold in holds])
        # Refused where there is no session.
        call(self.programs, self.endpoint, "planner", "automatic", {"is_automatic": False}, ("STATUS_OK", "STATUS_CONFLICT"))
        # What was under way may still end, and the cell is in another state then.
        status = "STATUS_STALE"
        while status == "STATUS_STALE":
            state = self.call("bridge", "state")["state"]
            reply = call(
                self.programs,
                self.endpoint,
                "bridge",
                "renew",
                {"state_number": state["state_number"]},
                ("STATUS_OK", "STATUS_STALE"),
            )
            status = reply["header"]["status"]
        begin(self.programs, self.endpoint, name, objects)


class Up:
    """`ppnpack up --console`, all in one process."""

    def __init__(self, programs, folder, token=None):
        self.programs, self.log = programs, folder / "up.log"
        command = [
            programs / "ppnpack",
            "up",
            "--console",
            "127.0.0.1:0",
            "--cell",
            "2cm",
            "--yaws",
            "4",
            "--tries",
            "0",
            "--listen",
            "tcp/127.0.0.1:0",
        ]
        environment = os.environ | {"NO_COLOR": "1"} | ({"PPNPACK_CONSOLE_TOKEN": token} if token else {})
        with open(self.log, "wb") as errors:
            self.child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
        # Ends the reading below, too.
        timer = threading.Timer(READY_WITHIN_S, self.child.kill)
        timer.start()
        said = {}
        for line in self.child.stdout:
            name, _, told = line.partition(": ")
            said[name] = told.strip()
            if line.startswith("Ready"):
                break
        timer.cancel()
        assert "Console" in said and "Zenoh" in said, f"it is not ready: {said}, {self.log.read_text()}"
        self.endpoint, self.url = said["Zenoh"].split()[0], said["Console"].rstrip("/") + "/"

    def begin(self, name, objects):
        begin(self.programs, self.endpoint, name, objects)

    def end(self):
        if self.child.poll() is None:
            self.child.send_signal(signal.SIGTERM)
        try:
            self.child.wait(ENDED_WITHIN_S)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()
        self.child.stdout.close()


def begin(programs, endpoint, name, objects):
    """Begins a session in automatic mode with these objects of the built-in set."""
    call(programs, endpoint, "planner", "begin", {"session_id": name, "is_automatic": True, "gives_up_pending": True})
    items = [{"item_id": f"{name}-{at}", "object": of} for at, of in enumerate(objects, 1)]
    call(programs, endpoint, "planner", "announce", {"items": items})


def call(programs: pathlib.Path, endpoint, service, method, fields, accepted=("STATUS_OK",)):
    """The reply to a request; one that is refused as busy is sent again, as the protocol has it."""
    command = [programs / "ppnpack", "call", service, method, json.dumps(fields), "--cell", Stack.CELL, "--connect", endpoint]
    deadline = time.monotonic() + READY_WITHIN_S
    while True:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30)
        assert done.stdout, f"{service} {method}: {done.stderr}"
        reply = json.loads(done.stdout)
        status = reply["header"]["status"]
        if status in accepted:
            return reply
        assert status == "STATUS_BUSY" and time.monotonic() < deadline, f"{service} {method}: {reply}"
        time.sleep(0.05)
