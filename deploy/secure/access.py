"""Makes the access control of the router (JSON5) of access.toml: whatever is not allowed there is denied.

    python3 access.py               prints it
    python3 access.py --check       only checks access.toml
    python3 access.py --names       prints the identities
    python3 access.py --services    prints those of them that are services

The variable ACCESS names another table. Names of streams, services and methods, and which service has which method, are
read from the wire's sources, and which streams a service publishes and reads from its own, so that the table cannot name
what does not exist, nor forget what does.
"""

import json
import os
import pathlib
import re
import sys

try:
    import tomllib
except ModuleNotFoundError:
    sys.exit("[access] this needs Python 3.11 or newer, for tomllib; found " + sys.version.split()[0])

HERE = pathlib.Path(__file__).resolve().parent
CRATES = HERE.parent.parent / "crates"
WIRE = CRATES / "wire" / "src"
SERVICES = CRATES / "services"
TABLE = pathlib.Path(os.environ.get("ACCESS") or HERE / "access.toml")
ENTRIES = ("serves", "publishes", "subscribes", "puts", "reads", "asks", "checks", "watches", "cells")
# Answers for itself: what it says passes no access control.
ROUTER = "router"
NAME = r"[a-z0-9_-]{1,64}"
# The names of other folders that `make` writes.
TAKEN = ("authority", ROUTER)
# Health is asked for under any cell, and under `all`.
ANY_CELL = ["*"]
# What may be asked in every cell at once: requests that change nothing.
LOOKS = ("explain", "heightmap", "outcome", "session", "shapes", "state")


class Wrong(Exception):
    """The table and the wire do not agree."""


class Wire:
    """The names of the protocol."""

    def __init__(self, sources):
        keys, requests = (sources / "keys.rs").read_text(), (sources / "rpc.rs").read_text()
        self.prefix = self._only(r'const PREFIX: &str = "([^"]+)"', keys, "PREFIX")
        self.streams = self._chunks("Stream", keys)
        self.services = self._chunks("Service", keys)
        self.methods = {service: [] for service in self.services.values()}
        rows = re.findall(r'^ *\w+ = "([^"]+)": \w+Request -> \w+, (?:Some\(Service::(\w+)\)|None);', requests, re.MULTILINE)
        for method, service in rows:
            if service:
                self.methods[self.services[service]].append(method)
        if len(rows) < requests.count("Request -> "):
            raise Wrong("rpc.rs has requests that cannot be read: adapt access.py to it")

    @staticmethod
    def _only(pattern, text, what):
        found = re.search(pattern, text, re.DOTALL)
        if not found:
            raise Wrong(f"keys.rs has no {what} any more: adapt access.py to it")
        return found.group(1)

    @classmethod
    def _chunks(cls, name, text):
        body = cls._only(rf"\n    {name} \{{\n(.*?)\n    \}}", text, name)
        return dict(re.findall(r'^ *(\w+) = "([^"]+)",', body, re.MULTILINE))

    def stream(self, cell, name):
        return f"{self.prefix}/{cell}/{name}"

    def request(self, cell, service, method):
        """Asked of any instance, and of one."""
        key = f"{self.prefix}/{cell}/rpc/{service}/{method}"
        return [key, f"{key}/*"]

    def alive(self, service, cell="*"):
        return f"{self.prefix}/{cell}/@live/{service}/*/*"

    def anything_alive(self):
        return f"{self.prefix}/*/@live/**"


def pick(wanted, known, where):
    """The names that are wanted, of those known; `*` is all."""
    if wanted == ["*"]:
        return sorted(known)
    for name in wanted:
        if name not in known:
            raise Wrong(f"{where}: the wire knows no '{name}'; there are {', '.join(sorted(known))}")
    return wanted


def asked(wire, name, entry):
    """(service, method) of what an identity asks."""
    for text in entry.get("asks", []):
        service, _, method = text.partition("/")
        [service] = pick([service], wire.methods, f"{name}.asks")
        for method in pick([method], wire.methods[service], f"{name}.asks of {service}"):
            yield service, method
    for service in pick(entry.get("checks", []), wire.methods, f"{name}.checks"):
        yield service, "health"


def streams(wire, name, entry, what):
    return pick(entry.get(what, []), set(wire.streams.values()), f"{name}.{what}")


def beside(wire, name, entry, what):
    """Keys that are none of the protocol's, as those of ROS 2; they cannot take in any of it."""
    for key in (found := entry.get(what, [])):
        chunks, own = key.split("/"), wire.prefix.split("/")
        if not all(chunks) or "**" in chunks[: len(own)] or all(a == b or "*" in a for a, b in zip(chunks, own)):
            raise Wrong(f"{name}.{what}: '{key}' has empty parts, or takes in what is under {wire.prefix}")
    return found


def watched(wire, name, entry):
    return pick(entry.get("watches", []), wire.methods, f"{name}.watches")


def cells_of(name, entry):
    """The cells of an identity, which it has to name; every one only where nothing there rests on it."""
    cells = entry.get("cells", [])
    if not cells or not all(re.fullmatch(rf"{NAME}|\*", cell) for cell in cells):
        raise Wrong(f'{name}: name its cells, such as cells = ["cell-1"]; found {cells}')
    return cells


def changes(wire, name, entry):
    """What an identity publishes and answers, on which decisions rest, and what it asks for that changes something."""
    asks = [f"{service}/{method}" for service, method in asked(wire, name, entry) if method not in (*LOOKS, "health")]
    published = streams(wire, name, entry, "publishes")
    answers = [f"answers of {entry['serves']}/{method}" for method in wire.methods.get(entry.get("serves"), [])]
    return [*published, *entry.get("puts", []), *asks, *answers]


def streams_in_sources(wire, service):
    """Which streams the sources of a service publish, which they read, and which they name at all."""
    found = {"publishes": set(), "subscribes": set(), "names": set()}
    for path in (SERVICES / service / "src").rglob("*.rs"):
        if path.name == "tests.rs":
            continue
        text = path.read_text().split("#[cfg(test)]\nmod")[0]
        for what, call in (("publishes", r"Publisher::new"), ("subscribes", r"\bsubscribe")):
            found[what] |= {wire.streams[name] for name in re.findall(call + r"\([^;{]*?\bStream::(\w+)", text)}
        found["names"] |= {wire.streams[name] for name in re.findall(r"\bStream::([A-Z]\w+)", text) if name in wire.streams}
    return found


def rules_of(wire, name, entry):
    """The rules of an identity: (what for, "ingress" or "egress" as the router sees it, messages, keys)."""
    cells = cells_of(name, entry)

    def stream_keys(what, cells=cells):
        return [wire.stream(cell, stream) for cell in cells for stream in streams(wire, name, entry, what)]

    def request_keys(requests, cells=cells):
        return [
            key
            for service, method in requests
            for cell in (ANY_CELL if method == "health" else cells)
            for key in wire.request(cell, service, method)
        ]

    # A publisher is told who subscribes, and who asks is told who answers: for all cells, as others may do so for all in
    # one expression.
    puts, reads = beside(wire, name, entry, "puts"), beside(wire, name, entry, "reads")
    yield "publishes", "ingress", ["put"], stream_keys("publishes") + puts
    yield "publishes", "egress", ["declare_subscriber"], stream_keys("publishes", ANY_CELL) + puts
    yield "subscribes", "ingress", ["declare_subscriber"], stream_keys("subscribes") + reads
    yield "subscribes", "egress", ["put"], stream_keys("subscribes") + reads
    asks = list(asked(wire, name, entry))
    yield "asks", "ingress", ["query"], request_keys(asks)
    yield "asks", "egress", ["reply"], request_keys(asks)
    yield "finds", "egress", ["declare_queryable"], request_keys(asks, ANY_CELL)
    services = watched(wire, name, entry)
    # Whoever watches every service may say so in one expression.
    alive = [wire.anything_alive()] if set(services) == set(wire.methods) else [wire.alive(name) for name in services]
    yield "watches", "ingress", ["declare_liveliness_subscriber", "liveliness_query"], alive
    yield "watches", "egress", ["liveliness_token"], alive
    for service in pick([entry["serves"]] if "serves" in entry else [], wire.methods, f"{name}.serves"):
        answered = request_keys((service, method) for method in [*wire.methods[service], "health"])
        yield "answers", "ingress", ["declare_queryable", "reply"], answered
        yield "answers", "egress", ["query"], answered
        yield "is alive", "ingress", ["liveliness_token"], [wire.alive(service, cell) for cell in cells]


def check(wire, table):
    """Whatever the wire has, somebody must be allowed to do, and somebody to use."""
    for name, entry in table.items():
        if name in TAKEN or not re.fullmatch(NAME, name):
            raise Wrong(f"'{name}' can be no identity: 1 to 64 of a-z, 0-9, _ and - are possible, but not {' or '.join(TAKEN)}")
        for key in set(entry) - set(ENTRIES):
            raise Wrong(f"{name}: '{key}' is no entry; there are {', '.join(ENTRIES)}")
        for what in ("puts", "reads"):
            beside(wire, name, entry, what)
        if "*" in cells_of(name, entry) and (changed := changes(wire, name, entry)):
            raise Wrong(f"{name}: name its cells, as it changes what is in them, by {', '.join(changed)}")
        # A robot's program has its sources elsewhere.
        if "serves" in entry and (SERVICES / entry["serves"]).is_dir():
            found = streams_in_sources(wire, entry["serves"])
            for what in ("publishes", "subscribes"):
                listed = set(streams(wire, name, entry, what))
                # Some are named in the sources elsewhere than where they are published or read.
                if not found[what] <= listed <= found["names"]:
                    raise Wrong(f"{name}.{what} lists {sorted(listed)}, its sources have {sorted(found[what] | listed & found['names'])}")
    unused = []
    for what in ("publishes", "subscribes"):
        used = {stream for name, entry in table.items() for stream in streams(wire, name, entry, what)}
        unused += [f"nobody {what} {stream}" for stream in wire.streams.values() if stream not in used]
    served = {entry.get("serves") for entry in table.values()} | {ROUTER}
    unused += [f"nobody serves {service}" for service in wire.methods if service not in served]
    used = {pair for name, entry in table.items() for pair in asked(wire, name, entry)}
    pairs = [(service, method) for service, methods in wire.methods.items() for method in methods]
    unused += [f"nobody asks {service}/{method}" for service, method in pairs if (service, method) not in used]
    if unused:
        raise Wrong("access.toml: " + "; ".join(unused))


def access_control(wire, table):
    """The router's configuration."""
    rules, policies = [], []
    for name, entry in table.items():
        own = []
        for what, flow, messages, keys in rules_of(wire, name, entry):
            if keys:
                rule = {"id": f"{name} {what}, {flow}", "permission": "allow", "flows": [flow]}
                own.append(rule | {"messages": messages, "key_exprs": keys})
        rules += own
        policies.append({"id": name, "subjects": [name], "rules": [rule["id"] for rule in own]})
    subjects = [{"id": name, "cert_common_names": [name], "link_protocols": ["tls"]} for name in table]
    return {
        "access_control": {
            "enabled": True,
            "default_permission": "deny",
            "rules": rules,
            "subjects": subjects,
            "policies": policies,
        }
    }


def main():
    wire, table = Wire(WIRE), tomllib.loads(TABLE.read_text())
    check(wire, table)
    made = access_control(wire, table)
    match sys.argv[1:]:
        case []:
            print(json.dumps(made, indent=2))
        case ["--names"]:
            print("\n".join(table))
        case ["--services"]:
            print("\n".join(name for name, entry in table.items() if "serves" in entry))
        case ["--check"]:
            print(f"[access] {len(table)} identities, {len(made['access_control']['rules'])} rules")
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    try:
        main()
    except (Wrong, OSError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"[access] {error}")
