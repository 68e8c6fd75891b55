from ppnpack.v1 import bridge_pb2 as _bridge_pb2
from ppnpack.v1 import header_pb2 as _header_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class TakeOverRequest(_message.Message):
    __slots__ = ("header", "bodies")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    BODIES_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    bodies: _containers.RepeatedCompositeFieldContainer[_bridge_pb2.Body]
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., bodies: _Optional[_Iterable[_Union[_bridge_pb2.Body, _Mapping]]] = ...) -> None: ...

class TakeOverReply(_message.Message):
    __slots__ = ("header", "start", "bodies")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    BODIES_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    start: str
    bodies: Bodies
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., start: _Optional[str] = ..., bodies: _Optional[_Union[Bodies, _Mapping]] = ...) -> None: ...

class CarryOutRequest(_message.Message):
    __slots__ = ("header", "start", "placement", "is_given_up")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_FIELD_NUMBER: _ClassVar[int]
    IS_GIVEN_UP_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    start: str
    placement: _bridge_pb2.PlaceRequest
    is_given_up: bool
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., start: _Optional[str] = ..., placement: _Optional[_Union[_bridge_pb2.PlaceRequest, _Mapping]] = ..., is_given_up: _Optional[bool] = ...) -> None: ...

class CarryOutReply(_message.Message):
    __slots__ = ("header", "outcome", "bodies")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    OUTCOME_FIELD_NUMBER: _ClassVar[int]
    BODIES_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    outcome: _bridge_pb2.Outcome
    bodies: Bodies
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., outcome: _Optional[_Union[_bridge_pb2.Outcome, _Mapping]] = ..., bodies: _Optional[_Union[Bodies, _Mapping]] = ...) -> None: ...

class BringEmptyRequest(_message.Message):
    __slots__ = ("header", "start", "renewal_id")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    RENEWAL_ID_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    start: str
    renewal_id: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., start: _Optional[str] = ..., renewal_id: _Optional[str] = ...) -> None: ...

class BringEmptyReply(_message.Message):
    __slots__ = ("header", "has_ended", "failure")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    HAS_ENDED_FIELD_NUMBER: _ClassVar[int]
    FAILURE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    has_ended: bool
    failure: str
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., has_ended: _Optional[bool] = ..., failure: _Optional[str] = ...) -> None: ...

class Bodies(_message.Message):
    __slots__ = ("bodies",)
    BODIES_FIELD_NUMBER: _ClassVar[int]
    bodies: _containers.RepeatedCompositeFieldContainer[_bridge_pb2.Body]
    def __init__(self, bodies: _Optional[_Iterable[_Union[_bridge_pb2.Body, _Mapping]]] = ...) -> None: ...
