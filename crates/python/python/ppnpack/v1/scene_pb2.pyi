from ppnpack.v1 import grid_pb2 as _grid_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class DoubtKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DOUBT_KIND_UNSPECIFIED: _ClassVar[DoubtKind]
    DOUBT_KIND_LITTLE_SEEN: _ClassVar[DoubtKind]
    DOUBT_KIND_RIM_AWAY: _ClassVar[DoubtKind]
    DOUBT_KIND_INTRUSION: _ClassVar[DoubtKind]
    DOUBT_KIND_NOT_STILL: _ClassVar[DoubtKind]
    DOUBT_KIND_ABOVE_RIM: _ClassVar[DoubtKind]
DOUBT_KIND_UNSPECIFIED: DoubtKind
DOUBT_KIND_LITTLE_SEEN: DoubtKind
DOUBT_KIND_RIM_AWAY: DoubtKind
DOUBT_KIND_INTRUSION: DoubtKind
DOUBT_KIND_NOT_STILL: DoubtKind
DOUBT_KIND_ABOVE_RIM: DoubtKind

class Scene(_message.Message):
    __slots__ = ("grid", "heights", "surface")
    GRID_FIELD_NUMBER: _ClassVar[int]
    HEIGHTS_FIELD_NUMBER: _ClassVar[int]
    SURFACE_FIELD_NUMBER: _ClassVar[int]
    grid: _grid_pb2.Grid
    heights: bytes
    surface: Surface
    def __init__(self, grid: _Optional[_Union[_grid_pb2.Grid, _Mapping]] = ..., heights: _Optional[bytes] = ..., surface: _Optional[_Union[Surface, _Mapping]] = ...) -> None: ...

class Surface(_message.Message):
    __slots__ = ("samples_per_cell", "heights_m", "support_m")
    SAMPLES_PER_CELL_FIELD_NUMBER: _ClassVar[int]
    HEIGHTS_M_FIELD_NUMBER: _ClassVar[int]
    SUPPORT_M_FIELD_NUMBER: _ClassVar[int]
    samples_per_cell: int
    heights_m: bytes
    support_m: bytes
    def __init__(self, samples_per_cell: _Optional[int] = ..., heights_m: _Optional[bytes] = ..., support_m: _Optional[bytes] = ...) -> None: ...

class Heightmap(_message.Message):
    __slots__ = ("id", "state_number", "captured_at_ns", "scene", "quality", "cell", "settings")
    ID_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    CAPTURED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    QUALITY_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    id: HeightmapId
    state_number: int
    captured_at_ns: int
    scene: Scene
    quality: HeightmapQuality
    cell: str
    settings: int
    def __init__(self, id: _Optional[_Union[HeightmapId, _Mapping]] = ..., state_number: _Optional[int] = ..., captured_at_ns: _Optional[int] = ..., scene: _Optional[_Union[Scene, _Mapping]] = ..., quality: _Optional[_Union[HeightmapQuality, _Mapping]] = ..., cell: _Optional[str] = ..., settings: _Optional[int] = ...) -> None: ...

class HeightmapId(_message.Message):
    __slots__ = ("epoch", "sequence")
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    epoch: int
    sequence: int
    def __init__(self, epoch: _Optional[int] = ..., sequence: _Optional[int] = ...) -> None: ...

class HeightmapQuality(_message.Message):
    __slots__ = ("points_inside", "unknown_cells", "cells", "processing_ns", "points_measured", "points_alone", "unseen_samples", "moved_cells", "clouds", "doubts")
    POINTS_INSIDE_FIELD_NUMBER: _ClassVar[int]
    UNKNOWN_CELLS_FIELD_NUMBER: _ClassVar[int]
    CELLS_FIELD_NUMBER: _ClassVar[int]
    PROCESSING_NS_FIELD_NUMBER: _ClassVar[int]
    POINTS_MEASURED_FIELD_NUMBER: _ClassVar[int]
    POINTS_ALONE_FIELD_NUMBER: _ClassVar[int]
    UNSEEN_SAMPLES_FIELD_NUMBER: _ClassVar[int]
    MOVED_CELLS_FIELD_NUMBER: _ClassVar[int]
    CLOUDS_FIELD_NUMBER: _ClassVar[int]
    DOUBTS_FIELD_NUMBER: _ClassVar[int]
    points_inside: int
    unknown_cells: int
    cells: int
    processing_ns: int
    points_measured: int
    points_alone: int
    unseen_samples: int
    moved_cells: int
    clouds: int
    doubts: _containers.RepeatedCompositeFieldContainer[Doubt]
    def __init__(self, points_inside: _Optional[int] = ..., unknown_cells: _Optional[int] = ..., cells: _Optional[int] = ..., processing_ns: _Optional[int] = ..., points_measured: _Optional[int] = ..., points_alone: _Optional[int] = ..., unseen_samples: _Optional[int] = ..., moved_cells: _Optional[int] = ..., clouds: _Optional[int] = ..., doubts: _Optional[_Iterable[_Union[Doubt, _Mapping]]] = ...) -> None: ...

class Doubt(_message.Message):
    __slots__ = ("kind", "message")
    KIND_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    kind: DoubtKind
    message: str
    def __init__(self, kind: _Optional[_Union[DoubtKind, str]] = ..., message: _Optional[str] = ...) -> None: ...
