"""Tests the observability profile beside a running stack: everything is scraped, and an alert reaches its receiver.

    python3 test_alerts.py FOLDER GATEWAY COMPOSE...

COMPOSE is the command line of docker-compose with the files and the project of the stack, of which one is FOLDER/tools.yaml,
which this writes: Prometheus and Alertmanager as they are installed on this machine, with shorter times. GATEWAY is this
machine's address in the network `outside`, where the receiver listens. Ends with perception stopped.
"""

import collections
import http.server
import json
import os
import pathlib
import queue
import re
import shutil
import subprocess
import sys
import threading
import time
import urllib.parse
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
# Nothing is sooner known than by asking again; what comes to the receiver is waited for.
ASKED_EVERY_S = 0.2
PATIENCE_S = 20.0
PROCESSES = {"router": 1, "perception": 1, "ppn": 1, "heuristic": 1, "bridge": 1, "planner": 1, "console": 1}
# What the stack has counted of its cell by the time that this runs.
COUNTED = (
    'ppnpack_outcomes_total{cell="cell-1", kind="OUTCOME_KIND_PLACED"}',
    'ppnpack_decisions_total{cell="cell-1", is_degraded="false"}',
    'ppnpack_sessions_ended_total{cell="cell-1", end="SESSION_END_FAILED"}',
    'ppnpack_stale_scenes_total{cell="cell-1"}',
    'ppnpack_received_total{stream="heightmap", cell="cell-1"}',
)
SHORTER = {
    "prometheus.yaml": {"scrape_interval: 5s": "scrape_interval: 1s", "evaluation_interval: 15s": "evaluation_interval: 1s",
                        "refresh_interval: 10s": "refresh_interval: 1s"},
    "alerts.yaml": {"for: 30s": "for: 2s"},
    "alertmanager.yaml": {"group_wait: 10s": "group_wait: 0s", "group_interval: 1m": "group_interval: 1s"},
}


def fail(text):
    sys.exit(f"[alerts] {text}")


def tools(folder):
    """Writes tools.yaml and what it mounts."""
    programs = {}
    for name, package in (("prometheus", "prometheus"), ("prometheus-alertmanager", "prometheus-alertmanager")):
        programs[name] = shutil.which(name) or fail(f"missing: {name}; get it with: apt-get install {package}")
    for name, changes in SHORTER.items():
        text = (HERE / name).read_text()
        for before, after in changes.items():
            if before not in text:
                fail(f"{name} has no '{before}' any more: adapt {pathlib.Path(__file__).name}")
            text = text.replace(before, after)
        (folder / name).write_text(text)
    (folder / "tools.yaml").write_text(f"""
services:
  prometheus:
    image: debian:bookworm-slim
    entrypoint: [prometheus]
    volumes:
      - {programs["prometheus"]}:/usr/local/bin/prometheus:ro
      - {folder}/prometheus.yaml:/etc/prometheus/prometheus.yaml:ro
      - {folder}/alerts.yaml:/etc/prometheus/alerts.yaml:ro
    networks: [cell, outside]
    ports: ["127.0.0.1::9090"]
  alertmanager:
    image: debian:bookworm-slim
    volumes:
      - {programs["prometheus-alertmanager"]}:/usr/local/bin/alertmanager:ro
      - /usr/share/prometheus/alertmanager:/usr/share/prometheus/alertmanager:ro
      - {folder}/alertmanager.yaml:/etc/alertmanager/alertmanager.yaml:ro
""")


def receive(address):
    """A webhook that keeps what it is told."""
    told = queue.Queue()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            told.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer((address, 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return told, f"http://{address}:{server.server_port}/?a=1&b=2"


class Prometheus:
    def __init__(self, address):
        self.address = address

    def get(self, path, **query):
        url = f"http://{self.address}/api/v1/{path}?{urllib.parse.urlencode(query)}"
        with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
            return json.load(answer)["data"]

    def await_that(self, what, look):
        """Asks until nothing is missing any more."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                missing = look()
            except OSError as error:
                missing = str(error)
            if not missing:
                return
            if time.monotonic() > deadline:
                fail(f"{what}: {missing} (after {PATIENCE_S} s)")
            time.sleep(ASKED_EVERY_S)

    def targets_missing(self):
        up = self.get("query", query='up{job="ppnpack"} == 1')["result"]
        counts = collections.Counter(series["metric"]["process"] for series in up)
        return {name: f"{counts[name]} of {count} up" for name, count in PROCESSES.items() if counts[name] != count}

    def rules_missing(self):
        rules = [rule for group in self.get("rules")["groups"] for rule in group["rules"]]
        loaded = {rule["name"] for rule in rules if rule["health"] == "ok"}
        return set(re.findall(r"- alert: (\w+)", (HERE / "alerts.yaml").read_text())) - loaded

    def alerts_left(self):
        """Before the first scrape everything is gone."""
        return [alert["labels"] for alert in self.get("alerts")["alerts"]]

    def counts_missing(self):
        return [query for query in COUNTED if not self.get("query", query=query)["result"]]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    folder, gateway, compose = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    tools(folder)
    told, receiver = receive(gateway)
    environment = os.environ | {"PPNPACK_ALERTS_TO": receiver}

    def run(*arguments):
        done = subprocess.run([*compose, *arguments], env=environment, capture_output=True, text=True)
        return done.stdout.strip() if done.returncode == 0 else fail(f"{' '.join(arguments)}: {done.stderr}")

    run("up", "--detach", "--no-deps", "prometheus", "alertmanager")
    prometheus = Prometheus(run("port", "prometheus", "9090"))
    prometheus.await_that("not everything is scraped", prometheus.targets_missing)
    prometheus.await_that("not all rules are evaluated", prometheus.rules_missing)
    prometheus.await_that("the cell is not counted", prometheus.counts_missing)
    prometheus.await_that("something else is wrong", prometheus.alerts_left)
    while not told.empty():
        told.get()
    run("stop", "--timeout", "12", "perception")
    stopped, heard = time.monotonic(), []
    wanted = {"alertname": "ProcessGone", "job": "ppnpack", "process": "perception"}
    while wanted not in heard:
        try:
            message = told.get(timeout=max(0.0, stopped + PATIENCE_S - time.monotonic()))
        except queue.Empty:
            fail(f"perception is stopped, and within {PATIENCE_S} s the receiver heard only of {heard}")
        heard += [alert["labels"] for alert in message["alerts"] if alert["status"] == "firing"]
    took_s = time.monotonic() - stopped
    print(f"[alerts] {sum(PROCESSES.values())} targets are up; that perception is gone came to the receiver after {took_s:.1f} s")


if __name__ == "__main__":
    main()
