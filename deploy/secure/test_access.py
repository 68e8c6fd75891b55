"""Tests a running stack of the secure profile: every identity gets what its table says, and strangers get nothing.

    python3 test_access.py --table > TABLE
    ACCESS=TABLE deploy/secure/make IDENTITIES
    ACCESS=TABLE python3 test_access.py tls/localhost:7447 IDENTITIES STRANGERS

TABLE is access.toml with two more cells that no service has, in which the identities speak to one another, so the stack may
be at work meanwhile: one of everybody who has cells, and one of the services alone. STRANGERS is a folder that `make` filled
with another authority.
"""

import datetime
import itertools
import json
import pathlib
import re
import subprocess
import sys
import threading
import time
import tomllib

import zenoh

import access

CELL = "access-test"
# Only the services have it: controller and sensor are not for it.
OTHER_CELL = "access-other"
# What is denied is not refused but dropped, so there is no end to wait for.
PATIENCE_S = 3.0
# For how long the certificate is valid that ends while it is used, and how soon after its end the link is to be closed.
VALID_S = 3
CLOSED_WITHIN_S = 5.0
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


def table_of_test():
    """access.toml with the cells of the test."""
    text = access.TABLE.read_text()
    text, services = re.subn(r'(?m)^(serves = .*\ncells = \["cell-1")\]$', rf'\1, "{CELL}", "{OTHER_CELL}"]', text)
    text, others = re.subn(r'(?m)^(cells = \["cell-1")\]$', rf'\1, "{CELL}"]', text)
    if not services or not others:
        sys.exit(f'[access] {access.TABLE} has no lines cells = ["cell-1"] any more: adapt table_of_test')
    return text


def exchange(wire, sessions):
    """Has everybody try everything; gives what came through as (kind, who gave, cell and what, who got)."""
    seen, kept = Seen(), []
    methods = [(service, method) for service in wire.methods for method in [*wire.methods[service], "health"]]
    for (name, own), cell in itertools.product(sessions.items(), (CELL, OTHER_CELL)):
        for stream in wire.streams.values():
            def on_sample(sample, got=name, what=f"{cell}/{stream}"):
                seen.add("stream", sample.payload.to_string(), what, got)
            kept.append(own.declare_subscriber(wire.stream(cell, stream), on_sample))
        for service, method in methods:
            def on_query(query, name=name):
                query.reply(query.key_expr, f"answer of {name}")
            kept.append(own.declare_queryable(wire.request(cell, service, method)[0], on_query))
        for service in wire.methods:
            kept.append(own.liveliness().declare_token(wire.alive(service, cell).replace("/*", f"/{name}")))
    time.sleep(1.0)
    for (name, own), cell in itertools.product(sessions.items(), (CELL, OTHER_CELL)):
        for stream in wire.streams.values():
            own.put(wire.stream(cell, stream), name)
        for service, method in methods:
            def on_reply(reply, got=name, what=f"{cell}/{service}/{method}"):
                text = bytes(reply.ok.payload) if reply.ok else b""
                if text.startswith(b"answer of "):
                    seen.add("request", text.decode().removeprefix("answer of "), what, got)
            key = wire.request(cell, service, method)[0]
            # Without consolidation: a session's answer to itself would take the place of the others'.
            own.get(key, on_reply, target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE,
                    timeout=PATIENCE_S)
        for service in wire.methods:
            def on_token(reply, got=name, what=f"{cell}/{service}", cell=cell):
                if reply.ok and f"/{cell}/" in str(reply.ok.key_expr):
                    seen.add("alive", str(reply.ok.key_expr).rsplit("/", 1)[1], what, got)
            own.liveliness().get(wire.alive(service), on_token, timeout=PATIENCE_S)
    time.sleep(PATIENCE_S + 0.5)
    # A session reaches itself without the router.
    return {way for way in seen.all if way[1] != way[3]}


def allowed(wire, table):
    """What should come through."""
    def may(what, name, entry, cell):
        own = access.cells_of(name, entry)
        is_own = "*" in own or cell in own
        service = entry.get("serves")
        match what:
            case "publishes" | "subscribes":
                return access.streams(wire, name, entry, what) if is_own else []
            # Health is asked for, and told, in any cell; who is alive is seen in any.
            case "asks":
                asked = access.asked(wire, name, entry)
                return [f"{service}/{method}" for service, method in asked if is_own or method == "health"]
            case "answers":
                methods = [*(wire.methods[service] if is_own else []), "health"] if service else []
                return [f"{service}/{method}" for method in methods]
            case "lives":
                return [service] if service and is_own else []
            case "watches":
                return access.watched(wire, name, entry)

    kinds = {"stream": ("publishes", "subscribes"), "request": ("answers", "asks"), "alive": ("lives", "watches")}
    pairs = list(itertools.permutations(table.items(), 2))
    return {
        (kind, giver, f"{cell}/{what}", getter)
        for kind, (gives, gets) in kinds.items()
        for (giver, of_giver), (getter, of_getter) in pairs
        for cell in (CELL, OTHER_CELL)
        for what in set(may(gives, giver, of_giver, cell)) & set(may(gets, getter, of_getter, cell))
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


def ending_identity(identities, folder):
    """Makes an observer whose certificate ends soon; gives when."""
    folder.mkdir()
    authority, request = identities / "authority", folder / "request.pem"
    ends = datetime.datetime.now(datetime.timezone.utc).replace(microsecond=0) + datetime.timedelta(seconds=VALID_S + 1)
    (folder / "issued").touch()
    (folder / "openssl.cnf").write_text(f"""
        [ca]
        default_ca = own
        [own]
        database = {folder}/issued
        new_certs_dir = {folder}
        rand_serial = yes
        default_md = sha256
        policy = any
        x509_extensions = client
        [any]
        commonName = supplied
        [client]
        basicConstraints = critical, CA:FALSE
        extendedKeyUsage = clientAuth
        subjectAltName = DNS:observer
    """)
    for command in (
        ["req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj", "/CN=observer",
         "-keyout", folder / "key.pem", "-out", request],
        ["ca", "-batch", "-notext", "-config", folder / "openssl.cnf", "-cert", authority / "certificate.pem",
         "-keyfile", authority / "key.pem", "-enddate", f"{ends:%Y%m%d%H%M%SZ}", "-in", request,
         "-out", folder / "certificate.pem"],
    ):
        subprocess.run(["openssl", *command], check=True, capture_output=True)
    (folder / "authority.pem").write_bytes((authority / "certificate.pem").read_bytes())
    return ends.timestamp()


def outliving(endpoint, identities, folder):
    """What is wrong with how long a link outlives the client's certificate."""
    ends = ending_identity(identities, folder)
    with session(endpoint, folder) as own:
        if not own.info.routers_zid():
            return ["a client with a certificate that has not ended yet is not connected"]
        while own.info.routers_zid():
            if time.time() > ends + CLOSED_WITHIN_S:
                return [f"a link is still open {CLOSED_WITHIN_S} s after its certificate ended"]
            time.sleep(0.05)
        if time.time() < ends:
            return ["a link was closed before its certificate ended"]
    return []


def main():
    if sys.argv[1:] == ["--table"]:
        return print(table_of_test(), end="")
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    endpoint, identities, strangers = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    wire, table = access.Wire(access.WIRE), tomllib.loads(access.TABLE.read_text())
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
    failures += outliving(endpoint, identities, strangers / "ending")
    if failures:
        sys.exit("\n".join(f"[access] {failure}" for failure in failures[:40]))
    print(f"[access] {len(should)} permissions hold and nothing else; {len(clients)} strangers got nothing; "
          f"{answered} calls under load")


if __name__ == "__main__":
    main()
