from ppnpack.v1 import geometry_pb2 as _geometry_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ArmLegKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ARM_LEG_KIND_UNSPECIFIED: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_DESCEND: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_LIFT: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_TRANSFER: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_INSERT: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_RETREAT: _ClassVar[ArmLegKind]
    ARM_LEG_KIND_RETURN: _ClassVar[ArmLegKind]
ARM_LEG_KIND_UNSPECIFIED: ArmLegKind
ARM_LEG_KIND_DESCEND: ArmLegKind
ARM_LEG_KIND_LIFT: ArmLegKind
ARM_LEG_KIND_TRANSFER: ArmLegKind
ARM_LEG_KIND_INSERT: ArmLegKind
ARM_LEG_KIND_RETREAT: ArmLegKind
ARM_LEG_KIND_RETURN: ArmLegKind

class ArmCycle(_message.Message):
    __slots__ = ("arm", "cycle_s", "container_from_item_at_pick", "grasp_yaw_rad", "grip_s", "release_s", "legs")
    ARM_FIELD_NUMBER: _ClassVar[int]
    CYCLE_S_FIELD_NUMBER: _ClassVar[int]
    CONTAINER_FROM_ITEM_AT_PICK_FIELD_NUMBER: _ClassVar[int]
    GRASP_YAW_RAD_FIELD_NUMBER: _ClassVar[int]
    GRIP_S_FIELD_NUMBER: _ClassVar[int]
    RELEASE_S_FIELD_NUMBER: _ClassVar[int]
    LEGS_FIELD_NUMBER: _ClassVar[int]
    arm: str
    cycle_s: float
    container_from_item_at_pick: _geometry_pb2.Pose
    grasp_yaw_rad: float
    grip_s: float
    release_s: float
    legs: _containers.RepeatedCompositeFieldContainer[ArmLeg]
    def __init__(self, arm: _Optional[str] = ..., cycle_s: _Optional[float] = ..., container_from_item_at_pick: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., grasp_yaw_rad: _Optional[float] = ..., grip_s: _Optional[float] = ..., release_s: _Optional[float] = ..., legs: _Optional[_Iterable[_Union[ArmLeg, _Mapping]]] = ...) -> None: ...

class ArmLeg(_message.Message):
    __slots__ = ("kind", "trajectory")
    KIND_FIELD_NUMBER: _ClassVar[int]
    TRAJECTORY_FIELD_NUMBER: _ClassVar[int]
    kind: ArmLegKind
    trajectory: Trajectory
    def __init__(self, kind: _Optional[_Union[ArmLegKind, str]] = ..., trajectory: _Optional[_Union[Trajectory, _Mapping]] = ...) -> None: ...

class Trajectory(_message.Message):
    __slots__ = ("time_s", "position_rad")
    TIME_S_FIELD_NUMBER: _ClassVar[int]
    POSITION_RAD_FIELD_NUMBER: _ClassVar[int]
    time_s: _containers.RepeatedScalarFieldContainer[float]
    position_rad: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, time_s: _Optional[_Iterable[float]] = ..., position_rad: _Optional[_Iterable[float]] = ...) -> None: ...
