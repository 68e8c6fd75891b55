from ppnpack.v1 import arm_pb2 as _arm_pb2
from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from ppnpack.v1 import header_pb2 as _header_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ExecutionPhase(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    EXECUTION_PHASE_UNSPECIFIED: _ClassVar[ExecutionPhase]
    EXECUTION_PHASE_ACCEPTED: _ClassVar[ExecutionPhase]
    EXECUTION_PHASE_ENDED: _ClassVar[ExecutionPhase]

class OutcomeKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    OUTCOME_KIND_UNSPECIFIED: _ClassVar[OutcomeKind]
    OUTCOME_KIND_PLACED: _ClassVar[OutcomeKind]
    OUTCOME_KIND_NOT_PLACED: _ClassVar[OutcomeKind]
    OUTCOME_KIND_LOST: _ClassVar[OutcomeKind]
    OUTCOME_KIND_UNKNOWN: _ClassVar[OutcomeKind]
EXECUTION_PHASE_UNSPECIFIED: ExecutionPhase
EXECUTION_PHASE_ACCEPTED: ExecutionPhase
EXECUTION_PHASE_ENDED: ExecutionPhase
OUTCOME_KIND_UNSPECIFIED: OutcomeKind
OUTCOME_KIND_PLACED: OutcomeKind
OUTCOME_KIND_NOT_PLACED: OutcomeKind
OUTCOME_KIND_LOST: OutcomeKind
OUTCOME_KIND_UNKNOWN: OutcomeKind

class PlaceRequest(_message.Message):
    __slots__ = ("header", "placement_id", "item_id", "object", "container_from_item", "state_number", "cycle", "decided_at_ns")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_ID_FIELD_NUMBER: _ClassVar[int]
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    CYCLE_FIELD_NUMBER: _ClassVar[int]
    DECIDED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    placement_id: str
    item_id: str
    object: str
    container_from_item: _geometry_pb2.Pose
    state_number: int
    cycle: _arm_pb2.ArmCycle
    decided_at_ns: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., placement_id: _Optional[str] = ..., item_id: _Optional[str] = ..., object: _Optional[str] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., state_number: _Optional[int] = ..., cycle: _Optional[_Union[_arm_pb2.ArmCycle, _Mapping]] = ..., decided_at_ns: _Optional[int] = ...) -> None: ...

class PlaceReply(_message.Message):
    __slots__ = ("header", "execution")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    EXECUTION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    execution: Execution
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., execution: _Optional[_Union[Execution, _Mapping]] = ...) -> None: ...

class OutcomeRequest(_message.Message):
    __slots__ = ("header", "placement_id")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_ID_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    placement_id: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., placement_id: _Optional[str] = ...) -> None: ...

class OutcomeReply(_message.Message):
    __slots__ = ("header", "execution")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    EXECUTION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    execution: Execution
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., execution: _Optional[_Union[Execution, _Mapping]] = ...) -> None: ...

class RenewRequest(_message.Message):
    __slots__ = ("header", "state_number")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    state_number: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., state_number: _Optional[int] = ...) -> None: ...

class RenewReply(_message.Message):
    __slots__ = ("header", "state_number")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    state_number: int
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., state_number: _Optional[int] = ...) -> None: ...

class HoldRequest(_message.Message):
    __slots__ = ("header", "reason", "is_aborting", "holder")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    IS_ABORTING_FIELD_NUMBER: _ClassVar[int]
    HOLDER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    reason: str
    is_aborting: bool
    holder: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., reason: _Optional[str] = ..., is_aborting: _Optional[bool] = ..., holder: _Optional[str] = ...) -> None: ...

class HoldReply(_message.Message):
    __slots__ = ("header", "state", "hold_id")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    HOLD_ID_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    state: CellState
    hold_id: str
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., state: _Optional[_Union[CellState, _Mapping]] = ..., hold_id: _Optional[str] = ...) -> None: ...

class ResumeRequest(_message.Message):
    __slots__ = ("header", "hold_ids", "most_placements")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    HOLD_IDS_FIELD_NUMBER: _ClassVar[int]
    MOST_PLACEMENTS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    hold_ids: _containers.RepeatedScalarFieldContainer[str]
    most_placements: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., hold_ids: _Optional[_Iterable[str]] = ..., most_placements: _Optional[int] = ...) -> None: ...

class ResumeReply(_message.Message):
    __slots__ = ("header", "state")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    state: CellState
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., state: _Optional[_Union[CellState, _Mapping]] = ...) -> None: ...

class ChangedRequest(_message.Message):
    __slots__ = ("header", "removed_item_ids")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    REMOVED_ITEM_IDS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    removed_item_ids: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., removed_item_ids: _Optional[_Iterable[str]] = ...) -> None: ...

class ChangedReply(_message.Message):
    __slots__ = ("header", "state")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    state: CellState
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., state: _Optional[_Union[CellState, _Mapping]] = ...) -> None: ...

class Execution(_message.Message):
    __slots__ = ("placement_id", "phase", "outcome")
    PLACEMENT_ID_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    OUTCOME_FIELD_NUMBER: _ClassVar[int]
    placement_id: str
    phase: ExecutionPhase
    outcome: Outcome
    def __init__(self, placement_id: _Optional[str] = ..., phase: _Optional[_Union[ExecutionPhase, str]] = ..., outcome: _Optional[_Union[Outcome, _Mapping]] = ...) -> None: ...

class Outcome(_message.Message):
    __slots__ = ("placement_id", "item_id", "kind", "failure", "container_from_item", "is_inside", "slide_m", "tilt_rad", "state_number", "is_found")
    PLACEMENT_ID_FIELD_NUMBER: _ClassVar[int]
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    FAILURE_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    IS_INSIDE_FIELD_NUMBER: _ClassVar[int]
    SLIDE_M_FIELD_NUMBER: _ClassVar[int]
    TILT_RAD_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    IS_FOUND_FIELD_NUMBER: _ClassVar[int]
    placement_id: str
    item_id: str
    kind: OutcomeKind
    failure: str
    container_from_item: _geometry_pb2.Pose
    is_inside: bool
    slide_m: float
    tilt_rad: float
    state_number: int
    is_found: bool
    def __init__(self, placement_id: _Optional[str] = ..., item_id: _Optional[str] = ..., kind: _Optional[_Union[OutcomeKind, str]] = ..., failure: _Optional[str] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., is_inside: _Optional[bool] = ..., slide_m: _Optional[float] = ..., tilt_rad: _Optional[float] = ..., state_number: _Optional[int] = ..., is_found: _Optional[bool] = ...) -> None: ...

class CellState(_message.Message):
    __slots__ = ("state_number", "executing_placement_id", "bodies", "is_simulated", "hold", "first_state_number", "clock_ns", "holds")
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    EXECUTING_PLACEMENT_ID_FIELD_NUMBER: _ClassVar[int]
    BODIES_FIELD_NUMBER: _ClassVar[int]
    IS_SIMULATED_FIELD_NUMBER: _ClassVar[int]
    HOLD_FIELD_NUMBER: _ClassVar[int]
    FIRST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    CLOCK_NS_FIELD_NUMBER: _ClassVar[int]
    HOLDS_FIELD_NUMBER: _ClassVar[int]
    state_number: int
    executing_placement_id: str
    bodies: _containers.RepeatedCompositeFieldContainer[Body]
    is_simulated: bool
    hold: Hold
    first_state_number: int
    clock_ns: int
    holds: _containers.RepeatedCompositeFieldContainer[Hold]
    def __init__(self, state_number: _Optional[int] = ..., executing_placement_id: _Optional[str] = ..., bodies: _Optional[_Iterable[_Union[Body, _Mapping]]] = ..., is_simulated: _Optional[bool] = ..., hold: _Optional[_Union[Hold, _Mapping]] = ..., first_state_number: _Optional[int] = ..., clock_ns: _Optional[int] = ..., holds: _Optional[_Iterable[_Union[Hold, _Mapping]]] = ...) -> None: ...

class Hold(_message.Message):
    __slots__ = ("reason", "id", "holder")
    REASON_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    HOLDER_FIELD_NUMBER: _ClassVar[int]
    reason: str
    id: str
    holder: str
    def __init__(self, reason: _Optional[str] = ..., id: _Optional[str] = ..., holder: _Optional[str] = ...) -> None: ...

class Body(_message.Message):
    __slots__ = ("item_id", "object", "container_from_item", "is_inside", "is_found")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    IS_INSIDE_FIELD_NUMBER: _ClassVar[int]
    IS_FOUND_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    object: str
    container_from_item: _geometry_pb2.Pose
    is_inside: bool
    is_found: bool
    def __init__(self, item_id: _Optional[str] = ..., object: _Optional[str] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., is_inside: _Optional[bool] = ..., is_found: _Optional[bool] = ...) -> None: ...

class CellStateRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ...) -> None: ...

class CellStateReply(_message.Message):
    __slots__ = ("header", "state")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    state: CellState
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., state: _Optional[_Union[CellState, _Mapping]] = ...) -> None: ...
