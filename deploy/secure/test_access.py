"""Tests a running stack of the secure profile: every identity gets what access.toml says, and strangers get nothing.

    python3 test_access.py tls/localhost:7447 IDENTITIES STRANGERS

IDENTITIES is the folder that `make` filled for the stack, STRANGERS one that it filled with another authority. The
identities speak to one another in a cell that no service has, so the stack may be at work meanwhile.
"""

import itertools
import json
import pathlib
import sys
import threading
import time
import tomllib

import zenoh

import access

CELL = "access-test"
# What is denied is not refused but dropped, so there is no end to wait for.
PATIENCE_S = 3.0
# What is sent under load, and for how long.
LOAD = bytes(20_000)
LOAD_S = 5.0


def session(endpoint, folder, has_certificate=True):
    link = {"root_ca_certificate": str(folder / "authority.pem"), "enable_mtls": has_certificate}
    if has_certificate:
        link |= {"connect_certificate": str(folder / "certificate.pem"), "connect_private_key": str(folder / "key.pem")}
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/link/tls", json.dumps(link))
    return zenoh.open(config)


class Seen:
    """What was received, from any thread."""

    def __init__(self):
        self.lock, self.all = threading.Lock(), set()

    def add(self, *what):
        with self.lock:
            self.all.add(what)


def exchange(wire, sessions):
    """Has everybody try everything; gives what came through as (kind, who gave, what, who got)."""
    seen, kept = Seen(), []
    methods = [(service, method) for service in wire.methods for method in [*wire.methods[service], "health"]]
    for name, own in sessions.items():
        for stream in wire.streams.values():
            def on_sample(sample, got=name, stream=stream):
                seen.add("stream", sample.payload.to_string(), stream, got)
            kept.append(own.declare_subscriber(wire.stream(CELL, stream), on_sample))
        for service, method in methods:
            def on_query(query, name=name):
                query.reply(query.key_expr, f"answer of {name}")
            kept.append(own.declare_queryable(wire.request(CELL, service, method)[0], on_query))
        for service in wire.methods:
            token = wire.alive(service).replace("*", CELL, 1).replace("/*", f"/{name}")
            kept.append(own.liveliness().declare_token(token))
    time.sleep(1.0)
    for name, own in sessions.items():
        for stream in wire.streams.values():
            own.put(wire.stream(CELL, stream), name)
        for service, method in methods:
            def on_reply(reply, got=name, what=f"{service}/{method}"):
                text = bytes(reply.ok.payload) if reply.ok else b""
                if text.startswith(b"answer of "):
                    seen.add("request", text.decode().removeprefix("answer of "), what, got)
            key = wire.request(CELL, service, method)[0]
            # Without consolidation: a session's answer to itself would take the place of the others'.
            own.get(key, on_reply, target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE,
                    timeout=PATIENCE_S)
        for service in wire.methods:
            def on_token(reply, got=name, service=service):
                if reply.ok and f"/{CELL}/" in str(reply.ok.key_expr):
                    seen.add("alive", str(reply.ok.key_expr).rsplit("/", 1)[1], service, got)
            own.liveliness().get(wire.alive(service), on_token, timeout=PATIENCE_S)
    time.sleep(PATIENCE_S + 0.5)
    # A session reaches itself without the router.
    return {way for way in seen.all if way[1] != way[3]}


def allowed(wire, table):
    """What should come through."""
    def may(what, name, entry):
        match what:
            case "publishes" | "subscribes":
                return access.streams(wire, name, entry, what)
            case "asks":
                return [f"{service}/{method}" for service, method in access.asked(wire, name, entry)]
            case "answers":
                service = entry.get("serves")
                return [f"{service}/{method}" for method in [*wire.methods[service], "health"]] if service else []
            case "lives":
                return [entry["serves"]] if "serves" in entry else []
            case "watches":
                return access.watched(wire, name, entry)

    kinds = {"stream": ("publishes", "subscribes"), "request": ("answers", "asks"), "alive": ("lives", "watches")}
    pairs = list(itertools.permutations(table.items(), 2))
    return {
        (kind, giver, what, getter)
        for kind, (gives, gets) in kinds.items()
        for (giver, of_giver), (getter, of_getter) in pairs
        for what in set(may(gives, giver, of_giver)) & set(may(gets, getter, of_getter))
    }


def load(wire, sessions):
    """Calls and a stream at full speed, both ways at once; gives how many calls were answered, and how many not.

    Zenoh's TLS links read and write one connection from two threads, which not every version of rustls bears: the router
    then ends within seconds.
    """
    counts, key = {True: 0, False: 0}, wire.request(CELL, "planner", "plan")[0]
    end = time.monotonic() + LOAD_S

    def call():
        while time.monotonic() < end:
            replies = sessions["controller"].get(key, payload=LOAD, timeout=PATIENCE_S)
            counts[any(reply.ok and bytes(reply.ok.payload) == LOAD for reply in replies)] += 1

    def publish():
        while time.monotonic() < end:
            sessions["bridge"].put(wire.stream(CELL, "state"), LOAD)
            time.sleep(0.001)

    with (
        sessions["planner"].declare_queryable(key, lambda query: query.reply(query.key_expr, LOAD)),
        sessions["controller"].declare_subscriber(wire.stream(CELL, "state"), lambda _: None),
    ):
        time.sleep(0.5)
        threads = [threading.Thread(target=work) for work in (call, call, call, publish)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return counts[True], counts[False]


def reached(wire, endpoint, folder, has_certificate):
    """What a client gets of the stack itself, whatever it tries."""
    seen = Seen()
    try:
        own = session(endpoint, folder, has_certificate)
    except zenoh.ZError:
        return set()
    with own:
        kept = [own.declare_subscriber(key, lambda sample: seen.add("stream", str(sample.key_expr)))
                for key in [f"{wire.prefix}/**", *(wire.stream("*", stream) for stream in wire.streams.values())]]
        for service, methods in wire.methods.items():
            for method in [*methods, "health"]:
                for cell in ("cell-1", "all"):
                    own.get(wire.request(cell, service, method)[0], lambda reply: seen.add("reply", str(reply)),
                            timeout=PATIENCE_S)
        own.liveliness().get(wire.anything_alive(), lambda reply: seen.add("alive", str(reply)),
                             timeout=PATIENCE_S)
        time.sleep(PATIENCE_S + 0.5)
        del kept
    return seen.all


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    endpoint, identities, strangers = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    wire, table = access.Wire(access.WIRE), tomllib.loads((access.HERE / "access.toml").read_text())
    sessions = {name: session(endpoint, identities / name) for name in table}
    came, should = exchange(wire, sessions), allowed(wire, table)
    for own in sessions.values():
        own.close()
    sessions = {name: session(endpoint, identities / name) for name in ("planner", "controller", "bridge")}
    answered, lost = load(wire, sessions)
    for own in sessions.values():
        own.close()
    failures = [f"under load {lost} calls of {answered + lost} were lost"] if lost or not answered else []
    failures += [f"came through, against access.toml: {what}" for what in sorted(came - should)]
    failures += [f"did not come through: {what}" for what in sorted(should - came)]
    trusting = strangers / "trusting"
    trusting.mkdir(exist_ok=True)
    # Another authority's certificate, of a client that knows the stack's authority.
    for name, source in (("authority.pem", identities / "controller"), ("certificate.pem", strangers / "controller"),
                         ("key.pem", strangers / "controller")):
        (trusting / name).write_bytes((source / name).read_bytes())
    clients = {
        "no certificate": (identities / "controller", False),
        "a certificate of another authority": (trusting, True),
        "another authority altogether": (strangers / "controller", True),
        "the identity of a sensor": (identities / "sensor", True),
    }
    for name, (folder, has_certificate) in clients.items():
        got = reached(wire, endpoint, folder, has_certificate)
        failures += [f"a client with {name} got {what}" for what in sorted(got)[:5]]
    # So that the others' silence says something.
    kinds = {kind for kind, _ in reached(wire, endpoint, identities / "observer", True)}
    silent = {"stream", "reply", "alive"} - kinds
    failures += [f"an observer got nothing of the kind '{kind}'" for kind in sorted(silent)]
    if failures:
        sys.exit("\n".join(f"[access] {failure}" for failure in failures[:40]))
    print(f"[access] {len(should)} permissions hold and nothing else; {len(clients)} strangers got nothing; "
          f"{answered} calls under load")


if __name__ == "__main__":
    main()
