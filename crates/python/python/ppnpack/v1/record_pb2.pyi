from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from ppnpack.v1 import header_pb2 as _header_pb2
from ppnpack.v1 import item_pb2 as _item_pb2
from ppnpack.v1 import planner_pb2 as _planner_pb2
from ppnpack.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PlanningRecord(_message.Message):
    __slots__ = ("cell", "session_id", "step", "planned_at_ns", "versions", "settings", "alternatives", "items", "candidates", "containers", "attempts", "is_cut", "decision")
    CELL_FIELD_NUMBER: _ClassVar[int]
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    PLANNED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    VERSIONS_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    ALTERNATIVES_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    CANDIDATES_FIELD_NUMBER: _ClassVar[int]
    CONTAINERS_FIELD_NUMBER: _ClassVar[int]
    ATTEMPTS_FIELD_NUMBER: _ClassVar[int]
    IS_CUT_FIELD_NUMBER: _ClassVar[int]
    DECISION_FIELD_NUMBER: _ClassVar[int]
    cell: str
    session_id: str
    step: int
    planned_at_ns: int
    versions: _header_pb2.Versions
    settings: str
    alternatives: int
    items: _containers.RepeatedCompositeFieldContainer[RecordedItem]
    candidates: _containers.RepeatedCompositeFieldContainer[RecordedCandidate]
    containers: _containers.RepeatedCompositeFieldContainer[RecordedContainer]
    attempts: _containers.RepeatedCompositeFieldContainer[RecordedAttempt]
    is_cut: bool
    decision: _planner_pb2.Decision
    def __init__(self, cell: _Optional[str] = ..., session_id: _Optional[str] = ..., step: _Optional[int] = ..., planned_at_ns: _Optional[int] = ..., versions: _Optional[_Union[_header_pb2.Versions, _Mapping]] = ..., settings: _Optional[str] = ..., alternatives: _Optional[int] = ..., items: _Optional[_Iterable[_Union[RecordedItem, _Mapping]]] = ..., candidates: _Optional[_Iterable[_Union[RecordedCandidate, _Mapping]]] = ..., containers: _Optional[_Iterable[_Union[RecordedContainer, _Mapping]]] = ..., attempts: _Optional[_Iterable[_Union[RecordedAttempt, _Mapping]]] = ..., is_cut: _Optional[bool] = ..., decision: _Optional[_Union[_planner_pb2.Decision, _Mapping]] = ...) -> None: ...

class RecordedItem(_message.Message):
    __slots__ = ("item_id", "object", "arrival")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    ARRIVAL_FIELD_NUMBER: _ClassVar[int]
    item_id: str
    object: str
    arrival: int
    def __init__(self, item_id: _Optional[str] = ..., object: _Optional[str] = ..., arrival: _Optional[int] = ...) -> None: ...

class RecordedCandidate(_message.Message):
    __slots__ = ("arrival", "pose", "item", "solid", "mass_kg", "heightmap_from_item", "waits_at", "rules", "stop")
    ARRIVAL_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    ITEM_FIELD_NUMBER: _ClassVar[int]
    SOLID_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    HEIGHTMAP_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    WAITS_AT_FIELD_NUMBER: _ClassVar[int]
    RULES_FIELD_NUMBER: _ClassVar[int]
    STOP_FIELD_NUMBER: _ClassVar[int]
    arrival: int
    pose: int
    item: bytes
    solid: bytes
    mass_kg: float
    heightmap_from_item: _geometry_pb2.Pose
    waits_at: _geometry_pb2.Pose
    rules: _planner_pb2.ItemRules
    stop: int
    def __init__(self, arrival: _Optional[int] = ..., pose: _Optional[int] = ..., item: _Optional[bytes] = ..., solid: _Optional[bytes] = ..., mass_kg: _Optional[float] = ..., heightmap_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., waits_at: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., rules: _Optional[_Union[_planner_pb2.ItemRules, _Mapping]] = ..., stop: _Optional[int] = ...) -> None: ...

class RecordedContainer(_message.Message):
    __slots__ = ("container", "scene", "content", "stops")
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    CONTENT_FIELD_NUMBER: _ClassVar[int]
    STOPS_FIELD_NUMBER: _ClassVar[int]
    container: str
    scene: _scene_pb2.Scene
    content: RecordedContent
    stops: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, container: _Optional[str] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., content: _Optional[_Union[RecordedContent, _Mapping]] = ..., stops: _Optional[_Iterable[int]] = ...) -> None: ...

class RecordedContent(_message.Message):
    __slots__ = ("bodies", "has_seen", "is_partial")
    BODIES_FIELD_NUMBER: _ClassVar[int]
    HAS_SEEN_FIELD_NUMBER: _ClassVar[int]
    IS_PARTIAL_FIELD_NUMBER: _ClassVar[int]
    bodies: _containers.RepeatedCompositeFieldContainer[RecordedBody]
    has_seen: bool
    is_partial: bool
    def __init__(self, bodies: _Optional[_Iterable[_Union[RecordedBody, _Mapping]]] = ..., has_seen: _Optional[bool] = ..., is_partial: _Optional[bool] = ...) -> None: ...

class RecordedBody(_message.Message):
    __slots__ = ("name", "solid", "container_from_item", "mass_kg", "carries_kg", "is_assumed")
    NAME_FIELD_NUMBER: _ClassVar[int]
    SOLID_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    CARRIES_KG_FIELD_NUMBER: _ClassVar[int]
    IS_ASSUMED_FIELD_NUMBER: _ClassVar[int]
    name: str
    solid: bytes
    container_from_item: _geometry_pb2.Pose
    mass_kg: float
    carries_kg: float
    is_assumed: bool
    def __init__(self, name: _Optional[str] = ..., solid: _Optional[bytes] = ..., container_from_item: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., mass_kg: _Optional[float] = ..., carries_kg: _Optional[float] = ..., is_assumed: _Optional[bool] = ...) -> None: ...

class RecordedAttempt(_message.Message):
    __slots__ = ("containers",)
    CONTAINERS_FIELD_NUMBER: _ClassVar[int]
    containers: _containers.RepeatedCompositeFieldContainer[AdmittedCandidates]
    def __init__(self, containers: _Optional[_Iterable[_Union[AdmittedCandidates, _Mapping]]] = ...) -> None: ...

class AdmittedCandidates(_message.Message):
    __slots__ = ("candidates",)
    CANDIDATES_FIELD_NUMBER: _ClassVar[int]
    candidates: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, candidates: _Optional[_Iterable[int]] = ...) -> None: ...

class Solid(_message.Message):
    __slots__ = ("name", "vertices_m", "triangles", "volume_m3", "pieces", "mass_kg", "centre_of_mass", "inertia_kg_m2", "carries_kg")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VERTICES_M_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    VOLUME_M3_FIELD_NUMBER: _ClassVar[int]
    PIECES_FIELD_NUMBER: _ClassVar[int]
    MASS_KG_FIELD_NUMBER: _ClassVar[int]
    CENTRE_OF_MASS_FIELD_NUMBER: _ClassVar[int]
    INERTIA_KG_M2_FIELD_NUMBER: _ClassVar[int]
    CARRIES_KG_FIELD_NUMBER: _ClassVar[int]
    name: str
    vertices_m: _containers.RepeatedScalarFieldContainer[float]
    triangles: _containers.RepeatedScalarFieldContainer[int]
    volume_m3: float
    pieces: _containers.RepeatedCompositeFieldContainer[ConvexPiece]
    mass_kg: float
    centre_of_mass: _geometry_pb2.Vector3
    inertia_kg_m2: _containers.RepeatedScalarFieldContainer[float]
    carries_kg: float
    def __init__(self, name: _Optional[str] = ..., vertices_m: _Optional[_Iterable[float]] = ..., triangles: _Optional[_Iterable[int]] = ..., volume_m3: _Optional[float] = ..., pieces: _Optional[_Iterable[_Union[ConvexPiece, _Mapping]]] = ..., mass_kg: _Optional[float] = ..., centre_of_mass: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., inertia_kg_m2: _Optional[_Iterable[float]] = ..., carries_kg: _Optional[float] = ...) -> None: ...

class ConvexPiece(_message.Message):
    __slots__ = ("vertices_m",)
    VERTICES_M_FIELD_NUMBER: _ClassVar[int]
    vertices_m: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, vertices_m: _Optional[_Iterable[float]] = ...) -> None: ...

class ShapesRequest(_message.Message):
    __slots__ = ("header", "ids")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    IDS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    ids: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., ids: _Optional[_Iterable[bytes]] = ...) -> None: ...

class ShapesReply(_message.Message):
    __slots__ = ("header", "shapes", "unknown")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SHAPES_FIELD_NUMBER: _ClassVar[int]
    UNKNOWN_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    shapes: _containers.RepeatedCompositeFieldContainer[Shape]
    unknown: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., shapes: _Optional[_Iterable[_Union[Shape, _Mapping]]] = ..., unknown: _Optional[_Iterable[bytes]] = ...) -> None: ...

class Shape(_message.Message):
    __slots__ = ("id", "item", "solid")
    ID_FIELD_NUMBER: _ClassVar[int]
    ITEM_FIELD_NUMBER: _ClassVar[int]
    SOLID_FIELD_NUMBER: _ClassVar[int]
    id: bytes
    item: _item_pb2.Item
    solid: Solid
    def __init__(self, id: _Optional[bytes] = ..., item: _Optional[_Union[_item_pb2.Item, _Mapping]] = ..., solid: _Optional[_Union[Solid, _Mapping]] = ...) -> None: ...
