from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Heuristic(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    HEURISTIC_UNSPECIFIED: _ClassVar[Heuristic]
    HEURISTIC_SDFM: _ClassVar[Heuristic]
    HEURISTIC_DBL: _ClassVar[Heuristic]
    HEURISTIC_HM: _ClassVar[Heuristic]
    HEURISTIC_MTA: _ClassVar[Heuristic]
    HEURISTIC_FIRST_FIT: _ClassVar[Heuristic]
    HEURISTIC_RANDOM: _ClassVar[Heuristic]
HEURISTIC_UNSPECIFIED: Heuristic
HEURISTIC_SDFM: Heuristic
HEURISTIC_DBL: Heuristic
HEURISTIC_HM: Heuristic
HEURISTIC_MTA: Heuristic
HEURISTIC_FIRST_FIT: Heuristic
HEURISTIC_RANDOM: Heuristic

class Objective(_message.Message):
    __slots__ = ("heuristic", "is_balanced", "weights", "seed", "above_rim_m")
    HEURISTIC_FIELD_NUMBER: _ClassVar[int]
    IS_BALANCED_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    ABOVE_RIM_M_FIELD_NUMBER: _ClassVar[int]
    heuristic: Heuristic
    is_balanced: bool
    weights: Weights
    seed: int
    above_rim_m: float
    def __init__(self, heuristic: _Optional[_Union[Heuristic, str]] = ..., is_balanced: _Optional[bool] = ..., weights: _Optional[_Union[Weights, _Mapping]] = ..., seed: _Optional[int] = ..., above_rim_m: _Optional[float] = ...) -> None: ...

class Weights(_message.Message):
    __slots__ = ("resting_height", "distance", "box_share", "balance", "corner", "surface_volume", "touching_area", "top_height")
    RESTING_HEIGHT_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    BOX_SHARE_FIELD_NUMBER: _ClassVar[int]
    BALANCE_FIELD_NUMBER: _ClassVar[int]
    CORNER_FIELD_NUMBER: _ClassVar[int]
    SURFACE_VOLUME_FIELD_NUMBER: _ClassVar[int]
    TOUCHING_AREA_FIELD_NUMBER: _ClassVar[int]
    TOP_HEIGHT_FIELD_NUMBER: _ClassVar[int]
    resting_height: float
    distance: float
    box_share: float
    balance: float
    corner: float
    surface_volume: float
    touching_area: float
    top_height: float
    def __init__(self, resting_height: _Optional[float] = ..., distance: _Optional[float] = ..., box_share: _Optional[float] = ..., balance: _Optional[float] = ..., corner: _Optional[float] = ..., surface_volume: _Optional[float] = ..., touching_area: _Optional[float] = ..., top_height: _Optional[float] = ...) -> None: ...
