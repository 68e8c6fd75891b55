"""What the client's tests talk to: a stack of real services, and services that answer as a test says."""

import json
import os
import signal
import subprocess
import threading
import time

import zenoh

READY_WITHIN_S = 120.0
ENDED_WITHIN_S = 30.0


class Stack:
    """`ppnpack up` on a port that the system chooses."""

    def __init__(self, program, log):
        self.log = log
        command = [program, "up", "--cell", "2cm", "--yaws", "2", "--tries", "0", "--listen", "tcp/127.0.0.1:0"]
        with open(log, "wb") as errors:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=os.environ | {"NO_COLOR": "1"})
        self.endpoint = self._ready()

    def _ready(self):
        # Ends the reading below, too.
        timer = threading.Timer(READY_WITHIN_S, self.process.kill)
        timer.start()
        endpoint = None
        try:
            for line in self.process.stdout:
                if line.startswith("Zenoh: "):
                    endpoint = line.split()[1]
                if line.startswith("Ready"):
                    return endpoint
        finally:
            timer.cancel()
        self.end(signal.SIGKILL)
        raise AssertionError(f"the stack is not ready within {READY_WITHIN_S} s: {self.log.read_text()}")

    def end(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            self.process.wait(ENDED_WITHIN_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()


class Service:
    """Answers requests to a method of a cell by a function of the request: it gives the replies, none for silence. Keeps the requests."""

    def __init__(self, method, request_type, answer, cell="cell-1"):
        config = zenoh.Config()
        config.insert_json5("mode", '"router"')
        config.insert_json5("listen/endpoints", '["tcp/127.0.0.1:0"]')
        config.insert_json5("scouting/multicast/enabled", "false")
        config.insert_json5("adminspace/enabled", "true")
        self.requests, self.times = [], []
        self._request_type, self._answer = request_type, answer
        self.session = zenoh.open(config)
        self._queryable = self.session.declare_queryable(f"ppnpack/v1/{cell}/rpc/{method}", self._on_query)
        (about,) = [reply.ok for reply in self.session.get(f"@/{self.session.zid()}/router")]
        (self.endpoint,) = json.loads(about.payload.to_string())["locators"]

    def _on_query(self, query):
        with query:
            self.times.append(time.monotonic())
            request = self._request_type.FromString(query.payload.to_bytes())
            self.requests.append(request)
            for reply in self._answer(request, len(self.requests)):
                query.reply(query.key_expr, reply.SerializeToString())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.session.close()
