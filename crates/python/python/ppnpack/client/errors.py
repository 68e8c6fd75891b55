"""What a request may end with other than its reply."""

from __future__ import annotations

import enum


class Status(enum.IntEnum):
    """How a service answered; docs/protocol.md says what each asks for. One that is not known here counts as FAILED."""

    OK = 1
    INVALID = 2
    NOT_FOUND = 3
    BUSY = 4
    TIMED_OUT = 5
    STALE = 6
    MISSING_ITEMS = 7
    CONFLICT = 8
    UNAVAILABLE = 9
    FAILED = 10
    HELD = 11
    FORGOTTEN = 12

    @classmethod
    def of(cls, number: int) -> Status:
        """The status of a reply's header."""
        try:
            return cls(number)
        except ValueError:
            return cls.FAILED


class ClientError(Exception):
    """Any error of the client. request names the service, the method and the cell."""

    def __init__(self, request: str, text: str) -> None:
        super().__init__(f"{request}: {text}")
        self.request = request


class Refused(ClientError):
    """A service refused a request, with a status and in its own words; sent again as it is, it would be refused again.

    Whatever passes (BUSY, TIMED_OUT, UNAVAILABLE) was waited for, and is only seen as Unanswered.last.
    """

    def __init__(self, request: str, status: Status, message: str) -> None:
        super().__init__(request, f"{status.name}: {message}")
        self.status = status
        self.message = message


class Unanswered(ClientError, TimeoutError):
    """The time was up before there was an answer, or only such as pass: the request may have been carried out.

    It may be sent again. last is the last refusal, if there was any.
    """

    def __init__(self, request: str, within_s: float, last: Refused | None) -> None:
        why = f"the last answer was {last.status.name}: {last.message}" if last else "nobody answered; is the service running?"
        super().__init__(request, f"not within {within_s:g} s: {why}")
        self.last = last


class Unreachable(ClientError, ConnectionError):
    """There is no connection to the router or service."""
