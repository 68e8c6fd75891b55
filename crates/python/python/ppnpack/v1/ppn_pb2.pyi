from ppnpack.v1 import header_pb2 as _header_pb2
from ppnpack.v1 import item_pb2 as _item_pb2
from ppnpack.v1 import placement_pb2 as _placement_pb2
from ppnpack.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ProposeRequest(_message.Message):
    __slots__ = ("header", "scene", "item_ids", "items", "percent")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    ITEM_IDS_FIELD_NUMBER: _ClassVar[int]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    PERCENT_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.RequestHeader
    scene: _scene_pb2.Scene
    item_ids: _containers.RepeatedScalarFieldContainer[bytes]
    items: _containers.RepeatedCompositeFieldContainer[_item_pb2.Item]
    percent: float
    def __init__(self, header: _Optional[_Union[_header_pb2.RequestHeader, _Mapping]] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., item_ids: _Optional[_Iterable[bytes]] = ..., items: _Optional[_Iterable[_Union[_item_pb2.Item, _Mapping]]] = ..., percent: _Optional[float] = ...) -> None: ...

class ProposeReply(_message.Message):
    __slots__ = ("header", "proposals", "missing_items")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PROPOSALS_FIELD_NUMBER: _ClassVar[int]
    MISSING_ITEMS_FIELD_NUMBER: _ClassVar[int]
    header: _header_pb2.ReplyHeader
    proposals: _containers.RepeatedCompositeFieldContainer[_placement_pb2.Placements]
    missing_items: _containers.RepeatedScalarFieldContainer[bytes]
    def __init__(self, header: _Optional[_Union[_header_pb2.ReplyHeader, _Mapping]] = ..., proposals: _Optional[_Iterable[_Union[_placement_pb2.Placements, _Mapping]]] = ..., missing_items: _Optional[_Iterable[bytes]] = ...) -> None: ...
