from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Status(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    STATUS_UNSPECIFIED: _ClassVar[Status]
    STATUS_OK: _ClassVar[Status]
    STATUS_INVALID: _ClassVar[Status]
    STATUS_NOT_FOUND: _ClassVar[Status]
    STATUS_BUSY: _ClassVar[Status]
    STATUS_TIMED_OUT: _ClassVar[Status]
    STATUS_STALE: _ClassVar[Status]
    STATUS_MISSING_ITEMS: _ClassVar[Status]
    STATUS_CONFLICT: _ClassVar[Status]
    STATUS_UNAVAILABLE: _ClassVar[Status]
    STATUS_FAILED: _ClassVar[Status]
    STATUS_HELD: _ClassVar[Status]
    STATUS_FORGOTTEN: _ClassVar[Status]
STATUS_UNSPECIFIED: Status
STATUS_OK: Status
STATUS_INVALID: Status
STATUS_NOT_FOUND: Status
STATUS_BUSY: Status
STATUS_TIMED_OUT: Status
STATUS_STALE: Status
STATUS_MISSING_ITEMS: Status
STATUS_CONFLICT: Status
STATUS_UNAVAILABLE: Status
STATUS_FAILED: Status
STATUS_HELD: Status
STATUS_FORGOTTEN: Status

class RequestHeader(_message.Message):
    __slots__ = ("request_id", "time_limit_us", "caller", "session_id", "cell")
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    TIME_LIMIT_US_FIELD_NUMBER: _ClassVar[int]
    CALLER_FIELD_NUMBER: _ClassVar[int]
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    request_id: str
    time_limit_us: int
    caller: str
    session_id: str
    cell: str
    def __init__(self, request_id: _Optional[str] = ..., time_limit_us: _Optional[int] = ..., caller: _Optional[str] = ..., session_id: _Optional[str] = ..., cell: _Optional[str] = ...) -> None: ...

class ReplyHeader(_message.Message):
    __slots__ = ("request_id", "status", "message", "stages", "versions")
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    STAGES_FIELD_NUMBER: _ClassVar[int]
    VERSIONS_FIELD_NUMBER: _ClassVar[int]
    request_id: str
    status: Status
    message: str
    stages: _containers.RepeatedCompositeFieldContainer[StageTiming]
    versions: Versions
    def __init__(self, request_id: _Optional[str] = ..., status: _Optional[_Union[Status, str]] = ..., message: _Optional[str] = ..., stages: _Optional[_Iterable[_Union[StageTiming, _Mapping]]] = ..., versions: _Optional[_Union[Versions, _Mapping]] = ...) -> None: ...

class StageTiming(_message.Message):
    __slots__ = ("stage", "duration_ns")
    STAGE_FIELD_NUMBER: _ClassVar[int]
    DURATION_NS_FIELD_NUMBER: _ClassVar[int]
    stage: str
    duration_ns: int
    def __init__(self, stage: _Optional[str] = ..., duration_ns: _Optional[int] = ...) -> None: ...

class Versions(_message.Message):
    __slots__ = ("software", "model", "configuration", "instance")
    SOFTWARE_FIELD_NUMBER: _ClassVar[int]
    MODEL_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    INSTANCE_FIELD_NUMBER: _ClassVar[int]
    software: str
    model: str
    configuration: str
    instance: str
    def __init__(self, software: _Optional[str] = ..., model: _Optional[str] = ..., configuration: _Optional[str] = ..., instance: _Optional[str] = ...) -> None: ...
