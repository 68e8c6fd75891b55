"""A connection to a router or a service."""

from __future__ import annotations

import json
import os
import re
from types import TracebackType

import zenoh

from ppnpack.client.cell import Cell
from ppnpack.client.errors import Unreachable

# Where a stack listens by default.
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"

_NAME = re.compile(r"[a-z0-9_-]{1,64}")


def default_endpoint() -> str:
    """The environment's PPNPACK_ENDPOINT, else where `ppnpack up` listens."""
    return os.environ.get("PPNPACK_ENDPOINT", DEFAULT_ENDPOINT)


class Connection:
    """A connection, for any number of cells and threads; Zenoh makes it anew where it is lost. Closes with `with`, or by close.

    endpoint: a router or a service, as "tcp/127.0.0.1:7447"; by default the environment's PPNPACK_ENDPOINT, else that one. zenoh_config: a
    Zenoh configuration file instead, as for mutual TLS. Raises Unreachable.
    """

    def __init__(self, endpoint: str | None = None, *, zenoh_config: str | os.PathLike[str] | None = None) -> None:
        where = endpoint or default_endpoint()
        try:
            if zenoh_config is not None:
                where = os.fspath(zenoh_config)
                config = zenoh.Config.from_file(where)
            else:
                config = zenoh.Config()
                config.insert_json5("mode", '"client"')
                config.insert_json5("connect/endpoints", json.dumps([where]))
                config.insert_json5("scouting/multicast/enabled", "false")
            self.session = zenoh.open(config)
        except zenoh.ZError as error:
            raise Unreachable(where, f"cannot be reached; is the stack running? {error}") from error

    def cell(self, name: str = "cell-1", *, limit_s: float = 5.0, patience_s: float = 60.0) -> Cell:
        """The cell of this name. limit_s: how long a service has for an answer. patience_s: how long a call takes at most, while the
        services may be busy or away; Unanswered is raised then."""
        if not _NAME.fullmatch(name) or name == "all":
            raise ValueError(f"{name!r} is no name of a cell: it has 1 to 64 characters of a-z 0-9 _ -, and is not all")
        return Cell(self.session, name, limit_s=limit_s, patience_s=patience_s)

    def close(self) -> None:
        """Ends the connection."""
        self.session.close()  # type: ignore[no-untyped-call]

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
