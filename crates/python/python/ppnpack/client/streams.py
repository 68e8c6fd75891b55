"""Streams: what a cell publishes. A slow reader loses the oldest messages, and holds nobody up."""

from __future__ import annotations

import collections
import threading
import time
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Generic, TypeVar

import zenoh
from google.protobuf.message import DecodeError

from ppnpack.client.requests import MESSAGE_BYTES

T = TypeVar("T")


class Stream(Generic[T]):
    """The messages of one stream, as they come; made by Cell. Closes with `with`, by close, or with its connection.

    Streams tell of things, and nothing depends on their arrival: whatever matters can be asked for.
    """

    def __init__(self, session: zenoh.Session, key: str, read: Callable[[bytes], T | None], kept: int) -> None:
        self._read = read
        self._messages: collections.deque[bytes] = collections.deque(maxlen=kept)
        self._changed = threading.Condition()
        self._is_closed = False
        self._key = key
        # Also told of the end of the session.
        self._subscriber = session.declare_subscriber(key, zenoh.handlers.Callback(self._on_sample, self._on_end))

    def _on_sample(self, sample: zenoh.Sample) -> None:
        if len(sample.payload) > MESSAGE_BYTES:
            return
        with self._changed:
            self._messages.append(sample.payload.to_bytes())
            self._changed.notify()

    def _on_end(self) -> None:
        with self._changed:
            self._is_closed = True
            self._messages.clear()
            self._changed.notify_all()

    def receive(self, within_s: float) -> T:
        """The next message. Raises TimeoutError where none comes in time, and ValueError where the stream is closed."""
        end_s = time.monotonic() + within_s
        while True:
            message = self._take(end_s)
            if message is None:
                raise TimeoutError(f"{self._key}: nothing within {within_s:g} s")
            read = self._readable(message)
            if read is not None:
                return read

    def __iter__(self) -> Iterator[T]:
        """Messages as they come, until the stream is closed."""
        while True:
            try:
                message = self._take(None)
            except ValueError:
                return
            read = self._readable(message) if message is not None else None
            if read is not None:
                yield read

    def _take(self, end_s: float | None) -> bytes | None:
        with self._changed:
            while not self._messages:
                if self._is_closed:
                    raise ValueError(f"{self._key}: the stream is closed")
                left_s = None if end_s is None else end_s - time.monotonic()
                if left_s is not None and left_s <= 0:
                    return None
                self._changed.wait(left_s)
            return self._messages.popleft()

    def _readable(self, message: bytes) -> T | None:
        """None for what is no message of this stream or cell: it is left out."""
        try:
            return self._read(message)
        except (DecodeError, ValueError):
            return None

    def close(self) -> None:
        """Ends it; what waits in receive or an iteration returns."""
        if not self._is_closed:
            self._on_end()
            self._subscriber.undeclare()  # type: ignore[no-untyped-call]

    def __enter__(self) -> Stream[T]:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
