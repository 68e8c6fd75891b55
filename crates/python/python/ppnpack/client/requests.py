"""Requests: one query on the key of a cell, service and method, sent again as docs/protocol.md says."""

from __future__ import annotations

import math
import time
import uuid
from typing import Protocol, TypeVar

import zenoh
from google.protobuf.message import DecodeError, Message

from ppnpack.client.errors import Refused, Status, Unanswered
from ppnpack.v1.header_pb2 import ReplyHeader, RequestHeader

# The longest message that is read; see the limits of the protocol.
MESSAGE_BYTES = 16 << 20
LONGEST_LIMIT_S = 600.0

# Zenoh keeps a query so much longer than the service has for its answer.
_MARGIN_S = 0.2
_FIRST_PAUSE_S = 0.05
_LONGEST_PAUSE_S = 2.0
_UNAVAILABLE_PAUSE_S = 1.0


class Request(Protocol):
    """A message with a request's header."""

    @property
    def header(self) -> RequestHeader: ...


class Reply(Protocol):
    """A message with a reply's header."""

    @property
    def header(self) -> ReplyHeader: ...


R = TypeVar("R", bound=Reply)


def encoding_of(message: Message) -> str:
    """The encoding that names the message, for recorders and viewers."""
    return f"application/protobuf;{message.DESCRIPTOR.full_name}"


def ask(
    session: zenoh.Session,
    cell: str,
    service: str,
    method: str,
    request: Request,
    reply_type: type[R],
    *,
    limit_s: float,
    patience_s: float,
) -> R:
    """Sends a request under one id until it is answered; the reply's status is OK.

    limit_s: how long the service has at each attempt. patience_s: how long all of it may take, pauses included. An id that the request has
    already is kept. Raises Refused and Unanswered, never later than patience_s.
    """
    for name, span_s in (("limit_s", limit_s), ("patience_s", patience_s)):
        if not (math.isfinite(span_s) and span_s > 0):
            raise ValueError(f"{name} is {span_s}: give seconds above 0")
    request.header.request_id = request.header.request_id or uuid.uuid4().hex
    request.header.cell = cell
    called = f"{service}/{method} of {cell}"
    end_s = time.monotonic() + patience_s
    busy_pause_s, failures = _FIRST_PAUSE_S, 0
    last: Refused | None = None
    while (left_s := end_s - time.monotonic()) > 0:
        margin_s = min(_MARGIN_S, left_s / 2)
        attempt_s = min(limit_s, left_s - margin_s, LONGEST_LIMIT_S)
        request.header.time_limit_us = max(1, int(attempt_s * 1e6))
        reply = attempt(session, f"ppnpack/v1/{cell}/rpc/{service}/{method}", request, reply_type, attempt_s + margin_s)
        # No reply is no refusal: nobody was there at that moment, as while a service starts.
        pause_s = _FIRST_PAUSE_S
        if reply is not None:
            status = Status.of(reply.header.status)
            if status is Status.OK:
                return reply
            last = Refused(called, status, reply.header.message)
            if status is Status.BUSY:
                pause_s, busy_pause_s = busy_pause_s, min(2 * busy_pause_s, _LONGEST_PAUSE_S)
            elif status is Status.TIMED_OUT:
                limit_s *= 2
            elif status is Status.UNAVAILABLE:
                pause_s = _UNAVAILABLE_PAUSE_S
            elif status is Status.FAILED and failures == 0:
                failures += 1
            else:
                raise last
        time.sleep(max(0.0, min(pause_s, end_s - time.monotonic())))
    raise Unanswered(called, patience_s, last)


def attempt(session: zenoh.Session, key: str, request: Request, reply_type: type[R], timeout_s: float) -> R | None:
    """The first reply that is to this request; others are late, and dropped."""
    assert isinstance(request, Message) and issubclass(reply_type, Message)
    try:
        replies = session.get(
            key,
            payload=request.SerializeToString(),
            encoding=encoding_of(request),
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
        )
        for answer in replies:
            if answer.ok is None or len(answer.ok.payload) > MESSAGE_BYTES:
                continue
            try:
                reply = reply_type.FromString(answer.ok.payload.to_bytes())
            except DecodeError:
                continue
            if reply.header.request_id == request.header.request_id:
                return reply
    except zenoh.ZError:
        # Without a connection there is nobody to answer; Zenoh connects again by itself.
        return None
    return None
