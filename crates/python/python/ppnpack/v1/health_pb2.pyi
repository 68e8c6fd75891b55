from ppnpack.v1 import header_pb2 as _header_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class HealthRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ...) -> None: ...

class HealthReply(_message.Message):
    __slots__ = ("header", "service", "is_ready", "checks", "uptime_ns", "cells")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SERVICE_FIELD_NUMBER: _ClassVar[int]
    IS_READY_FIELD_NUMBER: _ClassVar[int]
    CHECKS_FIELD_NUMBER: _ClassVar[int]
    UPTIME_NS_FIELD_NUMBER: _ClassVar[int]
    CELLS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    service: str
    is_ready: bool
    checks: _containers.RepeatedCompositeFieldContainer[HealthCheck]
    uptime_ns: int
    cells: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., service: _Optional[str] = ..., is_ready: _Optional[bool] = ..., checks: _Optional[_Iterable[_Union[HealthCheck, _Mapping]]] = ..., uptime_ns: _Optional[int] = ..., cells: _Optional[_Iterable[str]] = ...) -> None: ...

class HealthCheck(_message.Message):
    __slots__ = ("name", "is_passing", "message")
    NAME_FIELD_NUMBER: _ClassVar[int]
    IS_PASSING_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    name: str
    is_passing: bool
    message: str
    def __init__(self, name: _Optional[str] = ..., is_passing: _Optional[bool] = ..., message: _Optional[str] = ...) -> None: ...
