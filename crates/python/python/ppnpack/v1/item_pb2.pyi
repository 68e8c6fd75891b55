from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Item(_message.Message):
    __slots__ = ("name", "views", "mesh_volume_m3")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VIEWS_FIELD_NUMBER: _ClassVar[int]
    MESH_VOLUME_M3_FIELD_NUMBER: _ClassVar[int]
    name: str
    views: _containers.RepeatedCompositeFieldContainer[ItemView]
    mesh_volume_m3: float
    def __init__(self, name: _Optional[str] = ..., views: _Optional[_Iterable[_Union[ItemView, _Mapping]]] = ..., mesh_volume_m3: _Optional[float] = ...) -> None: ...

class ItemView(_message.Message):
    __slots__ = ("nx", "ny", "top", "bottom", "underside", "origin_from_corner", "centre_of_mass")
    NX_FIELD_NUMBER: _ClassVar[int]
    NY_FIELD_NUMBER: _ClassVar[int]
    TOP_FIELD_NUMBER: _ClassVar[int]
    BOTTOM_FIELD_NUMBER: _ClassVar[int]
    UNDERSIDE_FIELD_NUMBER: _ClassVar[int]
    ORIGIN_FROM_CORNER_FIELD_NUMBER: _ClassVar[int]
    CENTRE_OF_MASS_FIELD_NUMBER: _ClassVar[int]
    nx: int
    ny: int
    top: bytes
    bottom: bytes
    underside: Underside
    origin_from_corner: _geometry_pb2.Vector3
    centre_of_mass: _geometry_pb2.Vector3
    def __init__(self, nx: _Optional[int] = ..., ny: _Optional[int] = ..., top: _Optional[bytes] = ..., bottom: _Optional[bytes] = ..., underside: _Optional[_Union[Underside, _Mapping]] = ..., origin_from_corner: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., centre_of_mass: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class Underside(_message.Message):
    __slots__ = ("samples_per_cell", "heights_m")
    SAMPLES_PER_CELL_FIELD_NUMBER: _ClassVar[int]
    HEIGHTS_M_FIELD_NUMBER: _ClassVar[int]
    samples_per_cell: int
    heights_m: bytes
    def __init__(self, samples_per_cell: _Optional[int] = ..., heights_m: _Optional[bytes] = ...) -> None: ...
