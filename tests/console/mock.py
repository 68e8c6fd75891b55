"""A console that answers as a test says: the page's side of the console's API, without a cell.

python mock.py [--port 8771]    serves a cell that packs, to look at the page while it is worked on
"""

import argparse
import base64
import hashlib
import json
import math
import pathlib
import queue
import random
import struct
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

PAGE = pathlib.Path(__file__).resolve().parents[2] / "crates/services/console/page"
TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
TOKEN = "0123456789abcdef-token"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def now_ms():
    return int(time.time() * 1000)


class Console:
    """Serves the page and the parts that are published; keeps what is asked of the controls."""

    def __init__(self, port=0, controls=True):
        self.parts, self.revision, self.shapes, self.asked = {}, 0, {}, []
        self.streams, self.lock, self.is_silent, self.is_over = [], threading.Lock(), False, False
        self.answers = {}
        console = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *_):
                pass

            def do_GET(self):
                # A connection that is kept open outlives the server.
                if console.is_over:
                    self.close_connection = True
                else:
                    console.get(self)

            def do_POST(self):
                if console.is_over:
                    self.close_connection = True
                else:
                    console.post(self)

        self.server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/"
        why = None if controls else "no token is configured"
        self.publish("console", {"version": "0.1.0", "instance": "console-1", "started_ms": now_ms(), "controls": controls, "why_off": why})
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        threading.Thread(target=self.beat, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.is_over = True
        self.server.shutdown()
        self.server.server_close()
        self.end_streams()

    def publish(self, part, value, cell=None, container=None):
        """A part as it is from now on."""
        with self.lock:
            self.revision += 1
            whole = {"cell": cell, "container": container, "part": part, "revision": self.revision, "value": value}
            self.parts[(cell, container, part)] = whole
            self.send("part", whole)

    def end_streams(self):
        """Ends the streams of all pages, as a console that ends does."""
        with self.lock:
            for stream in self.streams:
                stream.put(None)

    def beat(self):
        while not self.is_over:
            time.sleep(1.0)
            with self.lock:
                self.send("beat", {"now_ms": now_ms(), "revision": self.revision})

    def send(self, kind, data):
        if not self.is_silent:
            for stream in self.streams:
                stream.put(f"event: {kind}\ndata: {json.dumps(data)}\n\n".encode())

    def shape(self, vertices, triangles):
        """Keeps a shape; gives its id."""
        content = struct.pack("<II", len(vertices), len(triangles))
        content += b"".join(struct.pack("<3f", *vertex) for vertex in vertices)
        content += b"".join(struct.pack("<3I", *triangle) for triangle in triangles)
        name = hashlib.sha256(content).hexdigest()
        self.shapes[name] = content
        return name

    def get(self, request):
        path = request.path.split("?")[0]
        if path == "/api/events" and self.is_silent:
            self.reply(request, 503, {"error": "too_many", "text": "too many pages", "question": None})
        elif path == "/api/events":
            self.stream(request)
        elif "/shapes/" in path:
            content = self.shapes.get(path.rsplit("/", 1)[1])
            if content is None:
                self.reply(request, 404, {"error": "unknown_shape", "text": "not known", "question": None})
            else:
                self.answer(request, 200, "application/octet-stream", content)
        elif "/explain/" in path:
            self.reply(request, 200, self.answers.get("explain", {}))
        else:
            file = PAGE / (path.strip("/") or "index.html")
            if file.parent == PAGE and file.is_file():
                self.answer(request, 200, TYPES[file.suffix], file.read_bytes())
            else:
                self.reply(request, 404, {"error": "not_found", "text": "there is no such page", "question": None})

    def stream(self, request):
        request.send_response(200)
        request.send_header("Content-Type", "text/event-stream")
        request.send_header("Cache-Control", "no-store")
        request.send_header("Connection", "close")
        request.end_headers()
        mine = queue.Queue()
        with self.lock:
            parts = list(self.parts.values())
            first = {"now_ms": now_ms(), "revision": self.revision, "parts": parts}
            mine.put(f"event: snapshot\ndata: {json.dumps(first)}\n\n".encode())
            self.streams.append(mine)
        try:
            while (message := mine.get()) is not None:
                request.wfile.write(message)
                request.wfile.flush()
        except OSError:
            pass
        finally:
            with self.lock:
                self.streams.remove(mine)
            request.close_connection = True

    def post(self, request):
        body = request.rfile.read(int(request.headers.get("Content-Length", 0)))
        action = request.path.rsplit("/", 1)[1]
        if request.headers.get("Authorization") != f"Bearer {TOKEN}":
            self.reply(request, 401, {"error": "token", "text": "the token is wrong", "question": None})
            return
        fields = json.loads(body)
        self.asked.append((action, fields))
        moves = action in ("resume", "step", "new_container") or (action == "automatic" and fields.get("is_on"))
        if moves and not fields.get("confirmed"):
            question = "The robot will move. Is nobody in the cell?"
            self.reply(request, 409, {"error": "unconfirmed", "text": "it has to be confirmed", "question": question})
            return
        status, answer = self.answers.get(action, (200, {"text": f"{action}: done.", "took_ms": 1.5}))
        self.reply(request, status, answer)

    def reply(self, request, status, body):
        self.answer(request, status, "application/json", json.dumps(body).encode())

    def answer(self, request, status, kind, content):
        request.send_response(status)
        request.send_header("Content-Type", kind)
        request.send_header("Content-Length", str(len(content)))
        request.send_header("Content-Security-Policy", POLICY)
        request.send_header("X-Content-Type-Options", "nosniff")
        request.end_headers()
        request.wfile.write(content)


def lathe(profile, sides=20):
    """A body of revolution: radii and heights from its bottom to its top, both closed."""
    vertices = [
        (radius * math.cos(2 * math.pi * side / sides), radius * math.sin(2 * math.pi * side / sides), z)
        for radius, z in profile
        for side in range(sides)
    ]
    triangles = []
    for ring in range(len(profile) - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            triangles += [(a, b, b + sides), (a, b + sides, a + sides)]
    return vertices, triangles


def box(x, y, z):
    vertices = [(x * (i & 1) - x / 2, y * (i >> 1 & 1) - y / 2, z * (i >> 2)) for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, [triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))]


OBJECTS = {
    "mug": lathe([(0, 0), (0.04, 0), (0.042, 0.09), (0.036, 0.09), (0.034, 0.01), (0, 0.01)]),
    "bottle": lathe([(0, 0), (0.033, 0), (0.035, 0.12), (0.014, 0.16), (0.014, 0.19), (0, 0.19)]),
    "bowl": lathe([(0, 0), (0.03, 0), (0.06, 0.03), (0.07, 0.055), (0.066, 0.055), (0.05, 0.025), (0, 0.008)]),
    "tuna_can": lathe([(0, 0), (0.042, 0), (0.042, 0.035), (0, 0.035)]),
    "tennis_ball": lathe([(0.033 * math.sin(math.pi * i / 10), 0.033 - 0.033 * math.cos(math.pi * i / 10)) for i in range(11)]),
    "cracker_box": box(0.16, 0.06, 0.21),
    "soap_bar": box(0.09, 0.06, 0.03),
    "gelatin_box": box(0.085, 0.073, 0.028),
    "puzzle_cube": box(0.057, 0.057, 0.057),
}
SIZE = (0.32, 0.32, 0.30)
CELL = "cell-1"


class Packing:
    """A cell that packs, slowly and without physics."""

    def __init__(self, console, seed=3):
        self.console, self.random = console, random.Random(seed)
        self.shape = {name: console.shape(*mesh) for name, mesh in OBJECTS.items()}
        self.waiting = [(f"item-{n}", self.random.choice(list(OBJECTS))) for n in range(1, 21)]
        self.items, self.decisions, self.steps, self.history, self.events = [], [], [], [[now_ms() - 60000, 0.0]], []
        self.heights = [[0.0] * 64 for _ in range(64)]
        self.number = 0
        self.held, self.holds, self.failure_id = None, ["h1"], ""
        console.publish("cells", [{"name": CELL, "containers": [CELL]}])
        self.services()
        self.publish("placing", "Placing mug into cell-1 (1 of 20).")

    def services(self, planner=True):
        named = [("planner", planner), ("bridge", True), ("perception", True), ("heuristic", True)]
        self.console.publish(
            "services",
            [
                {
                    "service": name,
                    "instance": f"{name}-1",
                    "cells": [] if name == "heuristic" else [CELL],
                    "is_alive": alive,
                    "is_ready": alive,
                    "failing": [] if name != "heuristic" else [],
                    "version": "0.1.0",
                    "uptime_s": 60.0,
                    "since_ms": now_ms() - 60000,
                }
                for name, alive in named
            ],
        )

    def size(self, object_):
        vertices, _ = OBJECTS[object_]
        return [max(v[axis] for v in vertices) - min(v[axis] for v in vertices) for axis in range(3)]

    def top(self, x, y, w, d):
        cells = [
            self.heights[i][j]
            for i in range(int(x * 200), min(64, int((x + w) * 200) + 1))
            for j in range(int(y * 200), min(64, int((y + d) * 200) + 1))
        ]
        return max(cells)

    def best(self, object_):
        w, d, h = self.size(object_)
        found = []
        for _ in range(200):
            x, y = self.random.uniform(0, SIZE[0] - w), self.random.uniform(0, SIZE[1] - d)
            z = self.top(x, y, w, d)
            if z + h <= SIZE[2]:
                found.append((z + 0.3 * (x + y), (x, y, z)))
        return sorted(found)[:4]

    def decide(self):
        item_id, object_ = self.waiting[0]
        places = self.best(object_)
        if not places:
            return None
        w, d, _ = self.size(object_)
        value, (x, y, z) = places[0]
        self.decisions.insert(
            0,
            {
                "decision_id": f"d-{len(self.steps)}",
                "at_ms": now_ms(),
                "step": len(self.steps),
                "item_id": item_id,
                "object": object_,
                "container": CELL,
                "pose": 0,
                "value": value,
                "shape": self.shape[object_],
                "container_from_shape": {"position_m": [x + w / 2, y + d / 2, z], "orientation": [0, 0, 0, 1]},
                "yaw_rad": 0.0,
                "corner_m": [x, y, z],
                "alternatives": [
                    {
                        "item_id": item_id,
                        "object": object_,
                        "pose": 0,
                        "value": v,
                        "shape": self.shape[object_],
                        "yaw_rad": 0.0,
                        "corner_m": list(at),
                    }
                    for v, at in places[1:]
                ],
                "others": [
                    {"item_id": i, "object": o, "reason": "rejected", "text": "where it fits it would not stand (1,204 placements)"}
                    for i, o in self.waiting[3:5]
                ],
                "degraded": [],
                "is_widened": False,
                "stages": [{"stage": "propose", "ms": 0.4}, {"stage": "evaluate", "ms": 3.1}, {"stage": "trial", "ms": 11.2}],
                "plan_ms": 15.2,
                "cycle_s": 6.1,
                "settling": {"tilt_rad": 0.01, "slide_m": 0.001, "disturbance_m": 0.0, "is_still": True, "above_rim_m": 0.0, "load_n": 3.0},
                "load": None,
                "outcome": None,
            },
        )
        del self.decisions[16:]
        self.steps.append({"step": len(self.steps), "at_ms": now_ms(), "plan_ms": 15.2, "took_s": None, "cycle_s": 6.1})
        self.say("info", "decided", f"{object_} ({item_id}) goes into {CELL}.")
        self.publish("placing", f"Placing {object_} into {CELL} ({len(self.steps)} of 20).")
        return self.decisions[0]

    def settle(self):
        decision = self.decisions[0]
        item_id, object_ = self.waiting.pop(0)
        decision["outcome"] = {"kind": "placed", "text": "", "slide_m": 0.001, "tilt_rad": 0.0, "at_ms": now_ms()}
        self.steps[-1]["took_s"] = 5.8 + self.random.random()
        w, d, h = self.size(object_)
        x, y, z = decision["corner_m"]
        for i in range(int(x * 200), min(64, int((x + w) * 200) + 1)):
            for j in range(int(y * 200), min(64, int((y + d) * 200) + 1)):
                self.heights[i][j] = z + h
        self.items.append(
            {
                "item_id": item_id,
                "object": object_,
                "shape": self.shape[object_],
                "container_from_shape": decision["container_from_shape"],
                "is_inside": True,
                "step": decision["step"],
                "inspection": {"kind": "as_planned", "slide_m": 0.0, "tilt_rad": 0.0, "reason": ""},
                "load": None,
            }
        )
        self.history.append([now_ms(), self.history[-1][1] + 0.6 * w * d * h / (SIZE[0] * SIZE[1] * SIZE[2])])
        self.say("info", "placed", f"{object_} was placed into {CELL}.")
        self.publish("planning", "Planning the next placement.")

    def say(self, level, kind, text):
        self.number += 1
        self.events.append({"number": self.number, "at_ms": now_ms(), "level": level, "kind": kind, "text": text})
        del self.events[:-200]

    def publish(self, doing, text, help_=None, stale=()):
        publish = self.console.publish
        pending = self.decisions[0] if self.decisions and self.decisions[0]["outcome"] is None else None
        publish(
            "status",
            {
                "doing": doing,
                "text": text,
                "help": help_,
                "stale": list(stale),
                "held": self.held,
                "holds": self.holds if self.held else [],
                "failure_id": self.failure_id,
                "is_moving": pending is not None,
            },
            CELL,
        )
        publish(
            "session",
            {
                "session_id": "s-1",
                "is_automatic": True,
                "step": len(self.steps),
                "end": None,
                "failure": "",
                "counts": {
                    "waiting": len(self.waiting) - bool(pending),
                    "decided": int(bool(pending)),
                    "packed": len(self.items),
                    "gone": 0,
                    "withdrawn": 0,
                    "set_aside": 0,
                    "forgotten": 0,
                },
                "reasons": [],
                "set_aside": [],
                "containers": [{"container": CELL, "sequence": 0, "is_open": True, "is_coming": False}],
                "closed": [],
                "pending": pending and pending["decision_id"],
            },
            CELL,
        )
        publish(
            "buffer",
            {
                "limit": 5,
                "more": max(0, len(self.waiting) - 12),
                "items": [
                    {
                        "item_id": i,
                        "object": o,
                        "state": "decided" if pending and i == pending["item_id"] else "waiting",
                        "is_choosable": at < 5,
                        "shape": self.shape[o] if at < 6 else None,
                        "order": "",
                        "is_fragile": o == "mug",
                        "is_bottom_only": False,
                        "is_upright": o == "bottle",
                        "carries_kg": 0.5 if o == "mug" else None,
                    }
                    for at, (i, o) in enumerate(self.waiting[:12])
                ],
            },
            CELL,
        )
        publish("decisions", self.decisions, CELL)
        took = [step["took_s"] for step in self.steps if step["took_s"]]
        publish(
            "cycles",
            {"steps": self.steps, "mean_took_s": sum(took) / len(took) if took else None, "mean_cycle_s": 6.1 if took else None},
            CELL,
        )
        publish("events", self.events, CELL)
        publish(
            "state",
            {
                "state_number": len(self.items),
                "held": self.held,
                "executing": pending and pending["decision_id"],
                "is_simulated": True,
                "heard_ms": now_ms(),
            },
            CELL,
            CELL,
        )
        publish("items", self.items, CELL, CELL)
        units = [round(h / 0.002) for row in self.heights for h in row]
        publish(
            "heightmap",
            {
                "nx": 64,
                "ny": 64,
                "cell_m": 0.005,
                "height_unit_m": 0.002,
                "size_m": list(SIZE),
                "rim_units": 150,
                "heights": base64.b64encode(struct.pack(f"<{len(units)}H", *units)).decode(),
                "state_number": len(self.items),
                "doubts": [],
                "unknown_cells": 0,
                "at_ms": now_ms(),
            },
            CELL,
            CELL,
        )
        publish(
            "figures",
            {
                "utilisation": self.history[-1][1],
                "items": len(self.items),
                "items_without_volume": 0,
                "filled": sum(map(sum, self.heights)) / 4096 / SIZE[2],
                "history": self.history,
            },
            CELL,
            CELL,
        )

    def pack(self, count):
        for _ in range(count):
            if not self.waiting or not self.decide():
                return
            self.settle()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=8771)
    arguments = parser.parse_args()
    with Console(arguments.port) as console:
        packing = Packing(console)
        print(f"{console.url} (token {TOKEN})", flush=True)
        while packing.waiting:
            time.sleep(2)
            packing.decide()
            time.sleep(3)
            packing.settle()
        threading.Event().wait()


if __name__ == "__main__":
    main()
