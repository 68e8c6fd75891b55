from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class NumericType(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    NUMERIC_TYPE_UNSPECIFIED: _ClassVar[NumericType]
    NUMERIC_TYPE_UINT8: _ClassVar[NumericType]
    NUMERIC_TYPE_INT8: _ClassVar[NumericType]
    NUMERIC_TYPE_UINT16: _ClassVar[NumericType]
    NUMERIC_TYPE_INT16: _ClassVar[NumericType]
    NUMERIC_TYPE_UINT32: _ClassVar[NumericType]
    NUMERIC_TYPE_INT32: _ClassVar[NumericType]
    NUMERIC_TYPE_FLOAT32: _ClassVar[NumericType]
    NUMERIC_TYPE_FLOAT64: _ClassVar[NumericType]
NUMERIC_TYPE_UNSPECIFIED: NumericType
NUMERIC_TYPE_UINT8: NumericType
NUMERIC_TYPE_INT8: NumericType
NUMERIC_TYPE_UINT16: NumericType
NUMERIC_TYPE_INT16: NumericType
NUMERIC_TYPE_UINT32: NumericType
NUMERIC_TYPE_INT32: NumericType
NUMERIC_TYPE_FLOAT32: NumericType
NUMERIC_TYPE_FLOAT64: NumericType

class PointCloud(_message.Message):
    __slots__ = ("sequence", "captured_at_ns", "state_number", "container_from_sensor", "point_stride", "fields", "data", "sensor", "cell")
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    CAPTURED_AT_NS_FIELD_NUMBER: _ClassVar[int]
    STATE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_SENSOR_FIELD_NUMBER: _ClassVar[int]
    POINT_STRIDE_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    DATA_FIELD_NUMBER: _ClassVar[int]
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    sequence: int
    captured_at_ns: int
    state_number: int
    container_from_sensor: _geometry_pb2.Pose
    point_stride: int
    fields: _containers.RepeatedCompositeFieldContainer[PackedField]
    data: bytes
    sensor: str
    cell: str
    def __init__(self, sequence: _Optional[int] = ..., captured_at_ns: _Optional[int] = ..., state_number: _Optional[int] = ..., container_from_sensor: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., point_stride: _Optional[int] = ..., fields: _Optional[_Iterable[_Union[PackedField, _Mapping]]] = ..., data: _Optional[bytes] = ..., sensor: _Optional[str] = ..., cell: _Optional[str] = ...) -> None: ...

class PackedField(_message.Message):
    __slots__ = ("name", "offset", "type")
    NAME_FIELD_NUMBER: _ClassVar[int]
    OFFSET_FIELD_NUMBER: _ClassVar[int]
    TYPE_FIELD_NUMBER: _ClassVar[int]
    name: str
    offset: int
    type: NumericType
    def __init__(self, name: _Optional[str] = ..., offset: _Optional[int] = ..., type: _Optional[_Union[NumericType, str]] = ...) -> None: ...
