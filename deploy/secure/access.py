"""Makes the access control of the router (JSON5) of access.toml: whatever is not allowed there is denied.

    python3 access.py            prints it
    python3 access.py --check    only checks access.toml
    python3 access.py --names    prints the identities

Names of streams, services and methods, and which service has which method, are read from the wire's sources, so that
the table cannot name what does not exist, nor forget what does.
"""

import json
import pathlib
import re
import sys

try:
    import tomllib
except ModuleNotFoundError:
    sys.exit("[access] this needs Python 3.11 or newer, for tomllib; found " + sys.version.split()[0])

HERE = pathlib.Path(__file__).resolve().parent
WIRE = HERE.parent.parent / "crates" / "wire" / "src"
ENTRIES = ("serves", "publishes", "subscribes", "puts", "reads", "asks", "checks", "watches", "cells")
# Answers for itself: what it says passes no access control.
ROUTER = "router"
# Health is asked for under any cell, and under `all`.
ANY_CELL = ["*"]


class Wrong(Exception):
    """The table and the wire do not agree."""


class Wire:
    """The names of the protocol."""

    def __init__(self, sources):
        keys, requests = (sources / "keys.rs").read_text(), (sources / "rpc.rs").read_text()
        self.prefix = self._only(r'const PREFIX: &str = "([^"]+)"', keys, "PREFIX")
        self.streams = self._chunks("Stream", keys)
        self.services = self._chunks("Service", keys)
        methods = self._chunks("Method", keys)
        self.methods = {service: [] for service in self.services.values()}
        rows = re.findall(r"\w+Request -> \w+: (?:Some\(Service::(\w+)\)|None), (\w+);", requests)
        for service, method in rows:
            if service:
                self.methods[self.services[service]].append(methods[method])
        if {method for _, method in rows} != set(methods):
            raise Wrong("rpc.rs and keys.rs do not have the same methods")

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

    def alive(self, service):
        return f"{self.prefix}/*/@live/{service}/*"

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


def rules_of(wire, name, entry):
    """The rules of an identity: (what for, messages to the router, messages from the router, keys)."""
    cells = entry.get("cells", ["*"])

    def keys(what):
        return [wire.stream(cell, stream) for cell in cells for stream in streams(wire, name, entry, what)]

    # A publisher is told who subscribes, and who asks is told who answers.
    yield "publishes", ["put"], ["declare_subscriber"], keys("publishes") + beside(wire, name, entry, "puts")
    yield "subscribes", ["declare_subscriber"], ["put"], keys("subscribes") + beside(wire, name, entry, "reads")
    requests = [
        key
        for service, method in asked(wire, name, entry)
        for cell in (ANY_CELL if method == "health" else cells)
        for key in wire.request(cell, service, method)
    ]
    yield "asks", ["query"], ["reply", "declare_queryable"], requests
    services = watched(wire, name, entry)
    # Whoever watches every service may say so in one expression.
    alive = [wire.anything_alive()] if set(services) == set(wire.methods) else [wire.alive(name) for name in services]
    yield "watches", ["declare_liveliness_subscriber", "liveliness_query"], ["liveliness_token"], alive
    for service in pick([entry["serves"]] if "serves" in entry else [], wire.methods, f"{name}.serves"):
        methods = [*wire.methods[service], "health"]
        answered = [key for method in methods for key in wire.request("*", service, method)]
        yield "answers", ["declare_queryable", "reply"], ["query"], answered
        yield "is alive", ["liveliness_token"], [], [wire.alive(service)]


def check(wire, table):
    """Whatever the wire has, somebody must be allowed to do, and somebody to use."""
    for name, entry in table.items():
        for key in set(entry) - set(ENTRIES):
            raise Wrong(f"{name}: '{key}' is no entry; there are {', '.join(ENTRIES)}")
        for what in ("puts", "reads"):
            beside(wire, name, entry, what)
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
        for what, incoming, outgoing, keys in rules_of(wire, name, entry):
            for flow, messages in (("ingress", incoming), ("egress", outgoing)):
                if keys and messages:
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
    wire, table = Wire(WIRE), tomllib.loads((HERE / "access.toml").read_text())
    check(wire, table)
    made = access_control(wire, table)
    match sys.argv[1:]:
        case []:
            print(json.dumps(made, indent=2))
        case ["--names"]:
            print("\n".join(table))
        case ["--check"]:
            print(f"[access] {len(table)} identities, {len(made['access_control']['rules'])} rules")
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    try:
        main()
    except (Wrong, OSError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"[access] {error}")
