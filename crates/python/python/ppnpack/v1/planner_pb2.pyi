from ppnpack.v1 import arm_pb2 as _arm_pb2
from ppnpack.v1 import bridge_pb2 as _bridge_pb2
from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from ppnpack.v1 import header_pb2 as _header_pb2
from ppnpack.v1 import item_pb2 as _item_pb2
from ppnpack.v1 import perception_pb2 as _perception_pb2
from ppnpack.v1 import placement_pb2 as _placement_pb2
from ppnpack.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PlanResult(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PLAN_RESULT_UNSPECIFIED: _ClassVar[PlanResult]
    PLAN_RESULT_DECIDED: _ClassVar[PlanResult]
    PLAN_RESULT_NOTHING_FITS: _ClassVar[PlanResult]
    PLAN_RESULT_NOTHING_WAITS: _ClassVar[PlanResult]

class Reason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    REASON_UNSPECIFIED: _ClassVar[Reason]
    REASON_TOO_LARGE: _ClassVar[Reason]
    REASON_NO_FIT: _ClassVar[Reason]
    REASON_REJECTED: _ClassVar[Reason]
    REASON_CONSTRAINED: _ClassVar[Reason]
    REASON_NOT_PROPOSED: _ClassVar[Reason]
    REASON_RULE: _ClassVar[Reason]

class ClosingReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CLOSING_REASON_UNSPECIFIED: _ClassVar[ClosingReason]
    CLOSING_REASON_REQUEST: _ClassVar[ClosingReason]
    CLOSING_REASON_NOTHING_FITS: _ClassVar[ClosingReason]
    CLOSING_REASON_FULL: _ClassVar[ClosingReason]
    CLOSING_REASON_ORDER_COMPLETE: _ClassVar[ClosingReason]

class SessionEnd(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SESSION_END_UNSPECIFIED: _ClassVar[SessionEnd]
    SESSION_END_ALL_PACKED: _ClassVar[SessionEnd]
    SESSION_END_NOTHING_FITS: _ClassVar[SessionEnd]
    SESSION_END_FAILED: _ClassVar[SessionEnd]
    SESSION_END_OTHERS_SET_ASIDE: _ClassVar[SessionEnd]

class ItemState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ITEM_STATE_UNSPECIFIED: _ClassVar[ItemState]
    ITEM_STATE_WAITING: _ClassVar[ItemState]
    ITEM_STATE_DECIDED: _ClassVar[ItemState]
    ITEM_STATE_PACKED: _ClassVar[ItemState]
    ITEM_STATE_GONE: _ClassVar[ItemState]
    ITEM_STATE_WITHDRAWN: _ClassVar[ItemState]
    ITEM_STATE_SET_ASIDE: _ClassVar[ItemState]
PLAN_RESULT_UNSPECIFIED: PlanResult
PLAN_RESULT_DECIDED: PlanResult
PLAN_RESULT_NOTHING_FITS: PlanResult
PLAN_RESULT_NOTHING_WAITS: PlanResult
REASON_UNSPECIFIED: Reason
REASON_TOO_LARGE: Reason
REASON_NO_FIT: Reason
REASON_REJECTED: Reason
REASON_CONSTRAINED: Reason
REASON_NOT_PROPOSED: Reason
REASON_RULE: Reason
CLOSING_REASON_UNSPECIFIED: ClosingReason
CLOSING_REASON_REQUEST: ClosingReason
CLOSING_REASON_NOTHING_FITS: ClosingReason
CLOSING_REASON_FULL: ClosingReason
CLOSING_REASON_ORDER_COMPLETE: ClosingReason
SESSION_END_UNSPECIFIED: SessionEnd
SESSION_END_ALL_PACKED: SessionEnd
SESSION_END_NOTHING_FITS: SessionEnd
SESSION_END_FAILED: SessionEnd
SESSION_END_OTHERS_SET_ASIDE: SessionEnd
ITEM_STATE_UNSPECIFIED: ItemState
ITEM_STATE_WAITING: ItemState
ITEM_STATE_DECIDED: ItemState
ITEM_STATE_PACKED: ItemState
ITEM_STATE_GONE: ItemState
ITEM_STATE_WITHDRAWN: ItemState
ITEM_STATE_SET_ASIDE: ItemState

class BeginRequest(_message.Message):
    __slots__ = ("header", "session_id", "keep_out", "is_automatic", "least_state_number", "set_aside", "gives_up_pending", "containers")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    KEEP_OUT_FIELD_NUMBER: _ClassVar[int]
    IS_AUTOMATIC_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_FIELD_NUMBER: _ClassVar[int]
    GIVES_UP_PENDING_FIELD_NUMBER: _ClassVar[int]
    CONTAINERS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    session_id: str
    keep_out: _containers.RepeatedCompositeFieldContainer[Region]
    is_automatic: bool
    least_state_number: int
    set_aside: int
    gives_up_pending: bool
    containers: _containers.RepeatedCompositeFieldContainer[ContainerStart]
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., session_id: _Optional[str] = ..., keep_out: _Optional[_Iterable[_Union[Region, _Mapping]]] = ..., is_automatic: _Optional[bool] = ..., least_state_number: _Optional[int] = ..., set_aside: _Optional[int] = ..., gives_up_pending: _Optional[bool] = ..., containers: _Optional[_Iterable[_Union[ContainerStart, _Mapping]]] = ...) -> None: ...

class ContainerStart(_message.Message):
    __slots__ = ("container", "keep_out", "least_state_number")
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    KEEP_OUT_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    container: str
    keep_out: _containers.RepeatedCompositeFieldContainer[Region]
    least_state_number: int
    def __init__(self, container: _Optional[str] = ..., keep_out: _Optional[_Iterable[_Union[Region, _Mapping]]] = ..., least_state_number: _Optional[int] = ...) -> None: ...

class BeginReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class Region(_message.Message):
    __slots__ = ("x_min_m", "y_min_m", "x_max_m", "y_max_m")
    X_MIN_M_FIELD_NUMBER: _ClassVar[int]
    Y_MIN_M_FIELD_NUMBER: _ClassVar[int]
    X_MAX_M_FIELD_NUMBER: _ClassVar[int]
    Y_MAX_M_FIELD_NUMBER: _ClassVar[int]
    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float
    def __init__(self, x_min_m: _Optional[float] = ..., y_min_m: _Optional[float] = ..., x_max_m: _Optional[float] = ..., y_max_m: _Optional[float] = ...) -> None: ...

class AnnounceRequest(_message.Message):
    __slots__ = ("header", "items")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    items: _containers.RepeatedCompositeFieldContainer[Announcement]
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., items: _Optional[_Iterable[_Union[Announcement, _Mapping]]] = ...) -> None: ...

class Announcement(_message.Message):
    __slots__ = ("item_id", "object", "item", "rules", "heightmap_from_item", "waits_at", "poses", "allowed_poses", "order_line")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    ITEM_FIELD_NUMBER: _ClassVar[int]
    RULES_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    WAITS_AT_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_POSES_FIELD_NUMBER: _ClassVar[int]
    ORDER_LINE_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    object: str
    item: _item_pb2.Item
    rules: ItemRules
    heightmap_from_item: _geometry_pb2.Pose
    waits_at: _geometry_pb2.Pose
    poses: int
    allowed_poses: _containers.RepeatedScalarFieldContainer[int]
    order_line: OrderLine
    def __init__(self, item_id: _Optional[str] = ..., object: _Optional[str] = ..., item: _Optional[_Union[_item_pb2.Item, _Mapping]] = ..., rules: _Optional[_Union[ItemRules, _Mapping]] = ..., heightmap_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., waits_at: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., poses: _Optional[int] = ..., allowed_poses: _Optional[_Iterable[int]] = ..., order_line: _Optional[_Union[OrderLine, _Mapping]] = ...) -> None: ...

class OrderLine(_message.Message):
    __slots__ = ("order", "group", "mass_kg", "bundle", "stop", "urgency", "order_items")
    ORDER_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    BUNDLE_FIELD_NUMBER: _ClassVar[int]
    STOP_FIELD_NUMBER: _ClassVar[int]
    URGENCY_FIELD_NUMBER: _ClassVar[int]
    ORDER_ITEMS_FIELD_NUMBER: _ClassVar[int]
    order: str
    group: str
    mass_kg: float
    bundle: str
    stop: int
    urgency: int
    order_items: int
    def __init__(self, order: _Optional[str] = ..., group: _Optional[str] = ..., mass_kg: _Optional[float] = ..., bundle: _Optional[str] = ..., stop: _Optional[int] = ..., urgency: _Optional[int] = ..., order_items: _Optional[int] = ...) -> None: ...

class ItemRules(_message.Message):
    __slots__ = ("is_fragile", "is_bottom_only", "is_upright", "carries_kg")
    IS_FRAGILE_FIELD_NUMBER: _ClassVar[int]
    IS_BOTTOM_ONLY_FIELD_NUMBER: _ClassVar[int]
    IS_UPRIGHT_FIELD_NUMBER: _ClassVar[int]
    CARRIES_KG_FIELD_NUMBER: _ClassVar[int]
    is_fragile: bool
    is_bottom_only: bool
    is_upright: bool
    carries_kg: float
    def __init__(self, is_fragile: _Optional[bool] = ..., is_bottom_only: _Optional[bool] = ..., is_upright: _Optional[bool] = ..., carries_kg: _Optional[float] = ...) -> None: ...

class AnnounceReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class WithdrawRequest(_message.Message):
    __slots__ = ("header", "item_id", "order")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    ORDER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    item_id: str
    order: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., item_id: _Optional[str] = ..., order: _Optional[str] = ...) -> None: ...

class WithdrawReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class PlanRequest(_message.Message):
    __slots__ = ("header", "alternatives")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ALTERNATIVES_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    alternatives: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., alternatives: _Optional[int] = ...) -> None: ...

class PlanReply(_message.Message):
    __slots__ = ("header", "result", "decision", "reasons", "set_aside")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    RESULT_FIELD_NUMBER: _ClassVar[int]
    DECISION_FIELD_NUMBER: _ClassVar[int]
    REASONS_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    result: PlanResult
    decision: Decision
    reasons: _containers.RepeatedCompositeFieldContainer[ItemReason]
    set_aside: _containers.RepeatedCompositeFieldContainer[ItemReason]
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., result: _Optional[_Union[PlanResult, str]] = ..., decision: _Optional[_Union[Decision, _Mapping]] = ..., reasons: _Optional[_Iterable[_Union[ItemReason, _Mapping]]] = ..., set_aside: _Optional[_Iterable[_Union[ItemReason, _Mapping]]] = ...) -> None: ...

class Decision(_message.Message):
    __slots__ = ("decision_id", "request_id", "session_id", "step", "item_id", "object", "placement", "container_from_item", "value", "alternatives", "buffer", "heightmap", "state_number", "degraded", "is_widened", "stages", "cycle", "set_aside", "settling", "pose", "decided_at_ns", "container", "load")
    DECISION_ID_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    ALTERNATIVES_FIELD_NUMBER: _ClassVar[int]
    BUFFER_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    DEGRADED_FIELD_NUMBER: _ClassVar[int]
    IS_WIDENED_FIELD_NUMBER: _ClassVar[int]
    STAGES_FIELD_NUMBER: _ClassVar[int]
    CYCLE_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_FIELD_NUMBER: _ClassVar[int]
    SETTLING_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    DECIDED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    LOAD_FIELD_NUMBER: _ClassVar[int]
    decision_id: str
    request_id: str
    session_id: str
    step: int
    item_id: str
    object: str
    placement: _placement_pb2.RestingPlacement
    container_from_item: _geometry_pb2.Pose
    value: float
    alternatives: _containers.RepeatedCompositeFieldContainer[_placement_pb2.RankedPlacement]
    buffer: _containers.RepeatedScalarFieldContainer[str]
    heightmap: _scene_pb2.HeightmapId
    state_number: int
    degraded: _containers.RepeatedScalarFieldContainer[str]
    is_widened: bool
    stages: _containers.RepeatedCompositeFieldContainer[_header_pb2.StageTiming]
    cycle: _arm_pb2.ArmCycle
    set_aside: _containers.RepeatedCompositeFieldContainer[ItemReason]
    settling: Settling
    pose: int
    decided_at_ns: int
    container: str
    load: Load
    def __init__(self, decision_id: _Optional[str] = ..., request_id: _Optional[str] = ..., session_id: _Optional[str] = ..., step: _Optional[int] = ..., item_id: _Optional[str] = ..., object: _Optional[str] = ..., placement: _Optional[_Union[_placement_pb2.RestingPlacement, _Mapping]] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., value: _Optional[float] = ..., alternatives: _Optional[_Iterable[_Union[_placement_pb2.RankedPlacement, _Mapping]]] = ..., buffer: _Optional[_Iterable[str]] = ..., heightmap: _Optional[_Union[_scene_pb2.HeightmapId, _Mapping]] = ..., state_number: _Optional[int] = ..., degraded: _Optional[_Iterable[str]] = ..., is_widened: _Optional[bool] = ..., stages: _Optional[_Iterable[_Union[_header_pb2.StageTiming, _Mapping]]] = ..., cycle: _Optional[_Union[_arm_pb2.ArmCycle, _Mapping]] = ..., set_aside: _Optional[_Iterable[_Union[ItemReason, _Mapping]]] = ..., settling: _Optional[_Union[Settling, _Mapping]] = ..., pose: _Optional[int] = ..., decided_at_ns: _Optional[int] = ..., container: _Optional[str] = ..., load: _Optional[_Union[Load, _Mapping]] = ...) -> None: ...

class Load(_message.Message):
    __slots__ = ("item_id", "estimated_kg", "carries_kg")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    ESTIMATED_KG_FIELD_NUMBER: _ClassVar[int]
    CARRIES_KG_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    estimated_kg: float
    carries_kg: float
    def __init__(self, item_id: _Optional[str] = ..., estimated_kg: _Optional[float] = ..., carries_kg: _Optional[float] = ...) -> None: ...

class Settling(_message.Message):
    __slots__ = ("tilt_rad", "slide_m", "disturbance_m", "is_still", "above_rim_m")
    TILT_RAD_FIELD_NUMBER: _ClassVar[int]
    SLIDE_M_FIELD_NUMBER: _ClassVar[int]
    DISTURBANCE_M_FIELD_NUMBER: _ClassVar[int]
    IS_STILL_FIELD_NUMBER: _ClassVar[int]
    ABOVE_RIM_M_FIELD_NUMBER: _ClassVar[int]
    tilt_rad: float
    slide_m: float
    disturbance_m: float
    is_still: bool
    above_rim_m: float
    def __init__(self, tilt_rad: _Optional[float] = ..., slide_m: _Optional[float] = ..., disturbance_m: _Optional[float] = ..., is_still: _Optional[bool] = ..., above_rim_m: _Optional[float] = ...) -> None: ...

class ItemReason(_message.Message):
    __slots__ = ("item_id", "reason", "text")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    reason: Reason
    text: str
    def __init__(self, item_id: _Optional[str] = ..., reason: _Optional[_Union[Reason, str]] = ..., text: _Optional[str] = ...) -> None: ...

class ReportRequest(_message.Message):
    __slots__ = ("header", "decision_id", "outcome")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    DECISION_ID_FIELD_NUMBER: _ClassVar[int]
    OUTCOME_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    decision_id: str
    outcome: _bridge_pb2.Outcome
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., decision_id: _Optional[str] = ..., outcome: _Optional[_Union[_bridge_pb2.Outcome, _Mapping]] = ...) -> None: ...

class ReportReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class OpenRequest(_message.Message):
    __slots__ = ("header", "start", "sequence")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    start: ContainerStart
    sequence: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., start: _Optional[_Union[ContainerStart, _Mapping]] = ..., sequence: _Optional[int] = ...) -> None: ...

class OpenReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class CloseRequest(_message.Message):
    __slots__ = ("header", "container", "sequence", "is_renewed", "text")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    IS_RENEWED_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    container: str
    sequence: int
    is_renewed: bool
    text: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., container: _Optional[str] = ..., sequence: _Optional[int] = ..., is_renewed: _Optional[bool] = ..., text: _Optional[str] = ...) -> None: ...

class CloseReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class ExplainRequest(_message.Message):
    __slots__ = ("header", "item_id")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    item_id: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., item_id: _Optional[str] = ...) -> None: ...

class ExplainReply(_message.Message):
    __slots__ = ("header", "best", "reason", "counts")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    BEST_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    COUNTS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    best: _placement_pb2.RankedPlacement
    reason: ItemReason
    counts: _placement_pb2.PlacementCounts
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., best: _Optional[_Union[_placement_pb2.RankedPlacement, _Mapping]] = ..., reason: _Optional[_Union[ItemReason, _Mapping]] = ..., counts: _Optional[_Union[_placement_pb2.PlacementCounts, _Mapping]] = ...) -> None: ...

class AutomaticRequest(_message.Message):
    __slots__ = ("header", "is_automatic", "failure_id")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    IS_AUTOMATIC_FIELD_NUMBER: _ClassVar[int]
    FAILURE_ID_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    is_automatic: bool
    failure_id: str
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., is_automatic: _Optional[bool] = ..., failure_id: _Optional[str] = ...) -> None: ...

class AutomaticReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class SessionRequest(_message.Message):
    __slots__ = ("header",)
    HEADER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ...) -> None: ...

class SessionReply(_message.Message):
    __slots__ = ("header", "session")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    session: Session
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., session: _Optional[_Union[Session, _Mapping]] = ...) -> None: ...

class Session(_message.Message):
    __slots__ = ("session_id", "items", "pending", "step", "is_automatic", "keep_out", "buffer", "end", "reasons", "failure", "least_state_number", "settled", "mean_cycle_s", "set_aside_limit", "set_aside", "past_session_ids", "containers", "closed", "forgotten_items", "failure_id", "failures", "switched_by")
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    PENDING_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    IS_AUTOMATIC_FIELD_NUMBER: _ClassVar[int]
    KEEP_OUT_FIELD_NUMBER: _ClassVar[int]
    BUFFER_FIELD_NUMBER: _ClassVar[int]
    END_FIELD_NUMBER: _ClassVar[int]
    REASONS_FIELD_NUMBER: _ClassVar[int]
    FAILURE_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    SETTLED_FIELD_NUMBER: _ClassVar[int]
    MEAN_CYCLE_S_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_LIMIT_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_FIELD_NUMBER: _ClassVar[int]
    PAST_SESSION_IDS_FIELD_NUMBER: _ClassVar[int]
    CONTAINERS_FIELD_NUMBER: _ClassVar[int]
    CLOSED_FIELD_NUMBER: _ClassVar[int]
    FORGOTTEN_ITEMS_FIELD_NUMBER: _ClassVar[int]
    FAILURE_ID_FIELD_NUMBER: _ClassVar[int]
    FAILURES_FIELD_NUMBER: _ClassVar[int]
    SWITCHED_BY_FIELD_NUMBER: _ClassVar[int]
    session_id: str
    items: _containers.RepeatedCompositeFieldContainer[SessionItem]
    pending: Decision
    step: int
    is_automatic: bool
    keep_out: _containers.RepeatedCompositeFieldContainer[Region]
    buffer: int
    end: SessionEnd
    reasons: _containers.RepeatedCompositeFieldContainer[ItemReason]
    failure: str
    least_state_number: int
    settled: _containers.RepeatedCompositeFieldContainer[SettledDecision]
    mean_cycle_s: float
    set_aside_limit: int
    set_aside: _containers.RepeatedCompositeFieldContainer[ItemReason]
    past_session_ids: _containers.RepeatedScalarFieldContainer[str]
    containers: _containers.RepeatedCompositeFieldContainer[SessionContainer]
    closed: _containers.RepeatedCompositeFieldContainer[ClosedContainer]
    forgotten_items: int
    failure_id: str
    failures: int
    switched_by: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, session_id: _Optional[str] = ..., items: _Optional[_Iterable[_Union[SessionItem, _Mapping]]] = ..., pending: _Optional[_Union[Decision, _Mapping]] = ..., step: _Optional[int] = ..., is_automatic: _Optional[bool] = ..., keep_out: _Optional[_Iterable[_Union[Region, _Mapping]]] = ..., buffer: _Optional[int] = ..., end: _Optional[_Union[SessionEnd, str]] = ..., reasons: _Optional[_Iterable[_Union[ItemReason, _Mapping]]] = ..., failure: _Optional[str] = ..., least_state_number: _Optional[int] = ..., settled: _Optional[_Iterable[_Union[SettledDecision, _Mapping]]] = ..., mean_cycle_s: _Optional[float] = ..., set_aside_limit: _Optional[int] = ..., set_aside: _Optional[_Iterable[_Union[ItemReason, _Mapping]]] = ..., past_session_ids: _Optional[_Iterable[str]] = ..., containers: _Optional[_Iterable[_Union[SessionContainer, _Mapping]]] = ..., closed: _Optional[_Iterable[_Union[ClosedContainer, _Mapping]]] = ..., forgotten_items: _Optional[int] = ..., failure_id: _Optional[str] = ..., failures: _Optional[int] = ..., switched_by: _Optional[_Iterable[str]] = ...) -> None: ...

class SessionContainer(_message.Message):
    __slots__ = ("container", "sequence", "is_open", "renewal_id", "keep_out", "least_state_number")
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    IS_OPEN_FIELD_NUMBER: _ClassVar[int]
    RENEWAL_ID_FIELD_NUMBER: _ClassVar[int]
    KEEP_OUT_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    container: str
    sequence: int
    is_open: bool
    renewal_id: str
    keep_out: _containers.RepeatedCompositeFieldContainer[Region]
    least_state_number: int
    def __init__(self, container: _Optional[str] = ..., sequence: _Optional[int] = ..., is_open: _Optional[bool] = ..., renewal_id: _Optional[str] = ..., keep_out: _Optional[_Iterable[_Union[Region, _Mapping]]] = ..., least_state_number: _Optional[int] = ...) -> None: ...

class ClosedContainer(_message.Message):
    __slots__ = ("container", "sequence", "reason", "text", "items")
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    container: str
    sequence: int
    reason: ClosingReason
    text: str
    items: int
    def __init__(self, container: _Optional[str] = ..., sequence: _Optional[int] = ..., reason: _Optional[_Union[ClosingReason, str]] = ..., text: _Optional[str] = ..., items: _Optional[int] = ...) -> None: ...

class SettledDecision(_message.Message):
    __slots__ = ("decision_id", "request_id", "kind")
    DECISION_ID_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    decision_id: str
    request_id: str
    kind: _bridge_pb2.OutcomeKind
    def __init__(self, decision_id: _Optional[str] = ..., request_id: _Optional[str] = ..., kind: _Optional[_Union[_bridge_pb2.OutcomeKind, str]] = ...) -> None: ...

class SessionItem(_message.Message):
    __slots__ = ("item_id", "object", "state", "rules", "placement", "planned", "container_from_item", "shape", "cycle_s", "heightmap_from_item", "waits_at", "inspection", "set_aside", "set_aside_step", "poses", "pose", "allowed_poses", "container", "container_sequence", "arrival", "order_line", "load", "is_found")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    RULES_FIELD_NUMBER: _ClassVar[int]
    PLACEMENT_FIELD_NUMBER: _ClassVar[int]
    PLANNED_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    SHAPE_FIELD_NUMBER: _ClassVar[int]
    CYCLE_S_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    WAITS_AT_FIELD_NUMBER: _ClassVar[int]
    INSPECTION_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_FIELD_NUMBER: _ClassVar[int]
    SET_ASIDE_STEP_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_POSES_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    ARRIVAL_FIELD_NUMBER: _ClassVar[int]
    ORDER_LINE_FIELD_NUMBER: _ClassVar[int]
    LOAD_FIELD_NUMBER: _ClassVar[int]
    IS_FOUND_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    object: str
    state: ItemState
    rules: ItemRules
    placement: _placement_pb2.RestingPlacement
    planned: _geometry_pb2.Pose
    container_from_item: _geometry_pb2.Pose
    shape: bytes
    cycle_s: float
    heightmap_from_item: _geometry_pb2.Pose
    waits_at: _geometry_pb2.Pose
    inspection: _perception_pb2.Inspection
    set_aside: ItemReason
    set_aside_step: int
    poses: int
    pose: int
    allowed_poses: _containers.RepeatedScalarFieldContainer[int]
    container: str
    container_sequence: int
    arrival: int
    order_line: OrderLine
    load: Load
    is_found: bool
    def __init__(self, item_id: _Optional[str] = ..., object: _Optional[str] = ..., state: _Optional[_Union[ItemState, str]] = ..., rules: _Optional[_Union[ItemRules, _Mapping]] = ..., placement: _Optional[_Union[_placement_pb2.RestingPlacement, _Mapping]] = ..., planned: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., shape: _Optional[bytes] = ..., cycle_s: _Optional[float] = ..., heightmap_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., waits_at: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., inspection: _Optional[_Union[_perception_pb2.Inspection, _Mapping]] = ..., set_aside: _Optional[_Union[ItemReason, _Mapping]] = ..., set_aside_step: _Optional[int] = ..., poses: _Optional[int] = ..., pose: _Optional[int] = ..., allowed_poses: _Optional[_Iterable[int]] = ..., container: _Optional[str] = ..., container_sequence: _Optional[int] = ..., arrival: _Optional[int] = ..., order_line: _Optional[_Union[OrderLine, _Mapping]] = ..., load: _Optional[_Union[Load, _Mapping]] = ..., is_found: _Optional[bool] = ...) -> None: ...
