from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Grid(_message.Message):
    __slots__ = ("container", "cell_m", "height_unit_m", "yaws_rad", "draft_rad", "corner_radius_m")
    CONTAINER_FIELD_NUMBER: _ClassVar[int]
    CELL_M_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_UNIT_M_FIELD_NUMBER: _ClassVar[int]
    YAWS_RAD_FIELD_NUMBER: _ClassVar[int]
    DRAFT_RAD_FIELD_NUMBER: _ClassVar[int]
    CORNER_RADIUS_M_FIELD_NUMBER: _ClassVar[int]
    container: BoxSize
    cell_m: float
    height_unit_m: float
    yaws_rad: _containers.RepeatedScalarFieldContainer[float]
    draft_rad: float
    corner_radius_m: float
    def __init__(self, container: _Optional[_Union[BoxSize, _Mapping]] = ..., cell_m: _Optional[float] = ..., height_unit_m: _Optional[float] = ..., yaws_rad: _Optional[_Iterable[float]] = ..., draft_rad: _Optional[float] = ..., corner_radius_m: _Optional[float] = ...) -> None: ...

class BoxSize(_message.Message):
    __slots__ = ("x_m", "y_m", "z_m")
    X_M_FIELD_NUMBER: _ClassVar[int]
    Y_M_FIELD_NUMBER: _ClassVar[int]
    Z_M_FIELD_NUMBER: _ClassVar[int]
    x_m: float
    y_m: float
    z_m: float
    def __init__(self, x_m: _Optional[float] = ..., y_m: _Optional[float] = ..., z_m: _Optional[float] = ...) -> None: ...
