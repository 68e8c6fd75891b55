from ppnpack.v1 import header_pb2 as _header_pb2
from ppnpack.v1 import item_pb2 as _item_pb2
from ppnpack.v1 import objective_pb2 as _objective_pb2
from ppnpack.v1 import placement_pb2 as _placement_pb2
from ppnpack.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class EvaluateRequest(_message.Message):
    __slots__ = ("header", "scene", "candidates", "items", "parts", "objective", "checks", "limit", "step")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    CANDIDATES_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    PARTS_FIELD_NUMBER: _ClassVar[int]
    OBJECTIVE_FIELD_NUMBER: _ClassVar[int]
    CHECKS_FIELD_NUMBER: _ClassVar[int]
    LIMIT_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    scene: _scene_pb2.Scene
    candidates: _containers.RepeatedCompositeFieldContainer[CandidateItem]
    items: _containers.RepeatedCompositeFieldContainer[_item_pb2.Item]
    parts: _containers.RepeatedCompositeFieldContainer[SearchPart]
    objective: _objective_pb2.Objective
    checks: _containers.RepeatedScalarFieldContainer[_placement_pb2.Check]
    limit: int
    step: int
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., candidates: _Optional[_Iterable[_Union[CandidateItem, _Mapping]]] = ..., items: _Optional[_Iterable[_Union[_item_pb2.Item, _Mapping]]] = ..., parts: _Optional[_Iterable[_Union[SearchPart, _Mapping]]] = ..., objective: _Optional[_Union[_objective_pb2.Objective, _Mapping]] = ..., checks: _Optional[_Iterable[_Union[_placement_pb2.Check, str]]] = ..., limit: _Optional[int] = ..., step: _Optional[int] = ...) -> None: ...

class CandidateItem(_message.Message):
    __slots__ = ("item_id", "arrival", "pose")
    ITEM_ID_FIELD_NUMBER: _ClassVar[int]
    ARRIVAL_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    item_id: bytes
    arrival: int
    pose: int
    def __init__(self, item_id: _Optional[bytes] = ..., arrival: _Optional[int] = ..., pose: _Optional[int] = ...) -> None: ...

class SearchPart(_message.Message):
    __slots__ = ("candidate", "proposals")
    CANDIDATE_FIELD_NUMBER: _ClassVar[int]
    PROPOSALS_FIELD_NUMBER: _ClassVar[int]
    candidate: int
    proposals: _placement_pb2.Placements
    def __init__(self, candidate: _Optional[int] = ..., proposals: _Optional[_Union[_placement_pb2.Placements, _Mapping]] = ...) -> None: ...

class EvaluateReply(_message.Message):
    __slots__ = ("header", "placements", "is_complete", "counts", "missing_items")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PLACEMENTS_FIELD_NUMBER: _ClassVar[int]
    IS_COMPLETE_FIELD_NUMBER: _ClassVar[int]
    COUNTS_FIELD_NUMBER: _ClassVar[int]
    MISSING_ITEMS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    placements: _containers.RepeatedCompositeFieldContainer[_placement_pb2.RankedPlacement]
    is_complete: bool
    counts: _containers.RepeatedCompositeFieldContainer[_placement_pb2.PlacementCounts]
    missing_items: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., placements: _Optional[_Iterable[_Union[_placement_pb2.RankedPlacement, _Mapping]]] = ..., is_complete: _Optional[bool] = ..., counts: _Optional[_Iterable[_Union[_placement_pb2.PlacementCounts, _Mapping]]] = ..., missing_items: _Optional[_Iterable[bytes]] = ...) -> None: ...
