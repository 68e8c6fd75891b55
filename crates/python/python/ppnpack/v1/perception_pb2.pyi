from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from ppnpack.v1 import header_pb2 as _header_pb2
from ppnpack.v1 import item_pb2 as _item_pb2
from ppnpack.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class UnknownReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    UNKNOWN_REASON_UNSPECIFIED: _ClassVar[UnknownReason]
    UNKNOWN_REASON_FEW_POINTS: _ClassVar[UnknownReason]
    UNKNOWN_REASON_NO_CANDIDATE: _ClassVar[UnknownReason]
    UNKNOWN_REASON_POOR_FIT: _ClassVar[UnknownReason]

class InspectionKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    INSPECTION_KIND_UNSPECIFIED: _ClassVar[InspectionKind]
    INSPECTION_KIND_AS_PLANNED: _ClassVar[InspectionKind]
    INSPECTION_KIND_MOVED: _ClassVar[InspectionKind]
    INSPECTION_KIND_TOPPLED: _ClassVar[InspectionKind]
    INSPECTION_KIND_MISSING: _ClassVar[InspectionKind]
    INSPECTION_KIND_UNCLEAR: _ClassVar[InspectionKind]
UNKNOWN_REASON_UNSPECIFIED: UnknownReason
UNKNOWN_REASON_FEW_POINTS: UnknownReason
UNKNOWN_REASON_NO_CANDIDATE: UnknownReason
UNKNOWN_REASON_POOR_FIT: UnknownReason
INSPECTION_KIND_UNSPECIFIED: InspectionKind
INSPECTION_KIND_AS_PLANNED: InspectionKind
INSPECTION_KIND_MOVED: InspectionKind
INSPECTION_KIND_TOPPLED: InspectionKind
INSPECTION_KIND_MISSING: InspectionKind
INSPECTION_KIND_UNCLEAR: InspectionKind

class HeightmapRequest(_message.Message):
    __slots__ = ("header", "least_state_number")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    least_state_number: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., least_state_number: _Optional[int] = ...) -> None: ...

class HeightmapReply(_message.Message):
    __slots__ = ("header", "heightmap", "age_ns")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FIELD_NUMBER: _ClassVar[int]
    AGE_NS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    heightmap: _scene_pb2.Heightmap
    age_ns: int
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., heightmap: _Optional[_Union[_scene_pb2.Heightmap, _Mapping]] = ..., age_ns: _Optional[int] = ...) -> None: ...

class ItemsRequest(_message.Message):
    __slots__ = ("header", "least_sequence")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LEAST_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    least_sequence: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., least_sequence: _Optional[int] = ...) -> None: ...

class ItemsReply(_message.Message):
    __slots__ = ("header", "items", "cloud_sequence", "captured_at_ns", "specks")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    CLOUD_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    CAPTURED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    SPECKS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    items: _containers.RepeatedCompositeFieldContainer[SeenItem]
    cloud_sequence: int
    captured_at_ns: int
    specks: int
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., items: _Optional[_Iterable[_Union[SeenItem, _Mapping]]] = ..., cloud_sequence: _Optional[int] = ..., captured_at_ns: _Optional[int] = ..., specks: _Optional[int] = ...) -> None: ...

class SeenItem(_message.Message):
    __slots__ = ("object", "unknown_reason", "item", "heightmap_from_item", "container_from_item", "fitness", "unexplained", "runner_up", "margin", "points")
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    UNKNOWN_REASON_FIELD_NUMBER: _ClassVar[int]
    ITEM_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    FITNESS_FIELD_NUMBER: _ClassVar[int]
    UNEXPLAINED_FIELD_NUMBER: _ClassVar[int]
    RUNNER_UP_FIELD_NUMBER: _ClassVar[int]
    MARGIN_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    object: str
    unknown_reason: UnknownReason
    item: _item_pb2.Item
    heightmap_from_item: _geometry_pb2.Pose
    container_from_item: _geometry_pb2.Pose
    fitness: float
    unexplained: float
    runner_up: str
    margin: float
    points: int
    def __init__(self, object: _Optional[str] = ..., unknown_reason: _Optional[_Union[UnknownReason, str]] = ..., item: _Optional[_Union[_item_pb2.Item, _Mapping]] = ..., heightmap_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., fitness: _Optional[float] = ..., unexplained: _Optional[float] = ..., runner_up: _Optional[str] = ..., margin: _Optional[float] = ..., points: _Optional[int] = ...) -> None: ...

class InspectRequest(_message.Message):
    __slots__ = ("header", "object", "planned", "before", "least_state_number")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    PLANNED_FIELD_NUMBER: _ClassVar[int]
    BEFORE_FIELD_NUMBER: _ClassVar[int]
    LEAST_STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    object: str
    planned: _geometry_pb2.Pose
    before: _scene_pb2.Scene
    least_state_number: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., object: _Optional[str] = ..., planned: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., before: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., least_state_number: _Optional[int] = ...) -> None: ...

class InspectReply(_message.Message):
    __slots__ = ("header", "inspection", "state_number")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    INSPECTION_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    inspection: Inspection
    state_number: int
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., inspection: _Optional[_Union[Inspection, _Mapping]] = ..., state_number: _Optional[int] = ...) -> None: ...

class Inspection(_message.Message):
    __slots__ = ("kind", "container_from_item", "slide_m", "tilt_rad", "is_inside", "fitness", "reason")
    KIND_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    SLIDE_M_FIELD_NUMBER: _ClassVar[int]
    TILT_RAD_FIELD_NUMBER: _ClassVar[int]
    IS_INSIDE_FIELD_NUMBER: _ClassVar[int]
    FITNESS_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    kind: InspectionKind
    container_from_item: _geometry_pb2.Pose
    slide_m: float
    tilt_rad: float
    is_inside: bool
    fitness: float
    reason: str
    def __init__(self, kind: _Optional[_Union[InspectionKind, str]] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., slide_m: _Optional[float] = ..., tilt_rad: _Optional[float] = ..., is_inside: _Optional[bool] = ..., fitness: _Optional[float] = ..., reason: _Optional[str] = ...) -> None: ...
