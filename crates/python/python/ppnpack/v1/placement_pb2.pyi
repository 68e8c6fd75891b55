from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Check(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CHECK_UNSPECIFIED: _ClassVar[Check]
    CHECK_PHYSICAL_STABILITY: _ClassVar[Check]
    CHECK_PUBLISHED_STABILITY: _ClassVar[Check]
    CHECK_FITS: _ClassVar[Check]
    CHECK_ARM: _ClassVar[Check]
    CHECK_ON_FLOOR: _ClassVar[Check]
    CHECK_UPRIGHT: _ClassVar[Check]
    CHECK_TRIAL: _ClassVar[Check]
    CHECK_LOAD: _ClassVar[Check]
    CHECK_BALANCE: _ClassVar[Check]
    CHECK_SEQUENCE: _ClassVar[Check]
CHECK_UNSPECIFIED: Check
CHECK_PHYSICAL_STABILITY: Check
CHECK_PUBLISHED_STABILITY: Check
CHECK_FITS: Check
CHECK_ARM: Check
CHECK_ON_FLOOR: Check
CHECK_UPRIGHT: Check
CHECK_TRIAL: Check
CHECK_LOAD: Check
CHECK_BALANCE: Check
CHECK_SEQUENCE: Check

class Placements(_message.Message):
    __slots__ = ("yaw", "x", "y")
    YAW_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    yaw: _containers.RepeatedScalarFieldContainer[int]
    x: _containers.RepeatedScalarFieldContainer[int]
    y: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, yaw: _Optional[_Iterable[int]] = ..., x: _Optional[_Iterable[int]] = ..., y: _Optional[_Iterable[int]] = ...) -> None: ...

class RestingPlacement(_message.Message):
    __slots__ = ("yaw", "x", "y", "resting_height")
    YAW_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    RESTING_HEIGHT_FIELD_NUMBER: _ClassVar[int]
    yaw: int
    x: int
    y: int
    resting_height: int
    def __init__(self, yaw: _Optional[int] = ..., x: _Optional[int] = ..., y: _Optional[int] = ..., resting_height: _Optional[int] = ...) -> None: ...

class RankedPlacement(_message.Message):
    __slots__ = ("candidate", "placement", "value", "pose")
    CANDIDATE_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    candidate: int
    placement: RestingPlacement
    value: float
    pose: int
    def __init__(self, candidate: _Optional[int] = ..., placement: _Optional[_Union[RestingPlacement, _Mapping]] = ..., value: _Optional[float] = ..., pose: _Optional[int] = ...) -> None: ...

class PlacementCounts(_message.Message):
    __slots__ = ("candidate", "possible", "proposed", "fitting", "refusals")
    CANDIDATE_FIELD_NUMBER: _ClassVar[int]
    POSSIBLE_FIELD_NUMBER: _ClassVar[int]
    PROPOSED_FIELD_NUMBER: _ClassVar[int]
    FITTING_FIELD_NUMBER: _ClassVar[int]
    REFUSALS_FIELD_NUMBER: _ClassVar[int]
    candidate: int
    possible: int
    proposed: int
    fitting: int
    refusals: _containers.RepeatedCompositeFieldContainer[Refusals]
    def __init__(self, candidate: _Optional[int] = ..., possible: _Optional[int] = ..., proposed: _Optional[int] = ..., fitting: _Optional[int] = ..., refusals: _Optional[_Iterable[_Union[Refusals, _Mapping]]] = ...) -> None: ...

class Refusals(_message.Message):
    __slots__ = ("check", "count", "detail")
    CHECK_FIELD_NUMBER: _ClassVar[int]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    DETAIL_FIELD_NUMBER: _ClassVar[int]
    check: Check
    count: int
    detail: str
    def __init__(self, check: _Optional[_Union[Check, str]] = ..., count: _Optional[int] = ..., detail: _Optional[str] = ...) -> None: ...
