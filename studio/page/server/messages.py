"""What a browser may send: the message types that the page needs, with bounded fields.

The viewer library decodes and handles many more, without bounds. Anything that does not decode as
one of these types is dropped (see `studio.page.server.gate`); what is passed on is encoded again
from the checked fields. A test compares the fields with the library's.
"""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta, Struct

LONGEST_TEXT = 20_000
"""Characters of a text field; twice the longest formula, so that the page can say so."""

MOST_ELEMENTS = 3
"""Numbers in one control."""

LARGEST_PART = 2**20
"""Bytes in one message of an upload."""

Id = Annotated[str, Meta(max_length=64)]
"""Of a control, a command or an upload; the library's have 36 characters."""
Name = Annotated[str, Meta(max_length=500)]
"""Of a scene node or a file."""
Count = Annotated[int, Meta(ge=0, le=2**53)]
Number = Annotated[float, Meta(ge=-1e9, le=1e9)]
"""Finite; the bounds exclude infinities and NaN."""
Positive = Annotated[float, Meta(ge=0, le=1e9)]
Unit = Annotated[float, Meta(ge=-1.01, le=1.01)]

Point = tuple[Number, Number, Number]
Pixel = tuple[Number, Number]
Modifier = (
    Literal[
        "cmd/ctrl",
        "alt",
        "shift",
        "cmd/ctrl+alt",
        "cmd/ctrl+shift",
        "alt+shift",
        "cmd/ctrl+alt+shift",
    ]
    | None
)

Value = (
    bool
    | float
    | Annotated[str, Meta(max_length=LONGEST_TEXT)]
    | Annotated[list[float], Meta(max_length=MOST_ELEMENTS)]
)
"""Of a control; `studio.page.server.controls` checks it against the control."""


class _Message(Struct, tag_field="type", forbid_unknown_fields=True):
    """The tag is the library's name of the message."""


class Updates(Struct, forbid_unknown_fields=True):
    """The library sets any attribute of the control by name; the page sends only values."""

    value: Value


class ControlUpdate(_Message, tag="GuiUpdateMessage"):
    """A control was used."""

    uuid: Id
    updates: Updates


class CommandTrigger(_Message, tag="CommandTriggerMessage"):
    """A command was chosen, or its key was pressed."""

    uuid: Id


class Camera(_Message, tag="ViewerCameraMessage"):
    """Where the browser looks from; the first makes the connection a client."""

    wxyz: tuple[Unit, Unit, Unit, Unit]
    position: Point
    fov: Positive
    near: Positive
    far: Positive
    image_height: Positive
    image_width: Positive
    look_at: Point
    up_direction: Point


class NodeClick(_Message, tag="SceneNodeClickMessage"):
    """A click on an object of the scene."""

    name: Name
    instance_index: Count | None
    ray_origin: Point
    ray_direction: Point
    screen_pos: Pixel
    modifier: Modifier
    owner: Id = ""


class NodeDrag(_Message, tag="SceneNodeDragMessage"):
    """A drag of an object of the scene."""

    phase: Literal["start", "update", "end"]
    name: Name
    instance_index: Count | None
    start_position: Point
    start_screen_pos: Pixel
    end_position: Point
    end_screen_pos: Pixel
    button: Literal["left", "middle", "right"]
    modifier: Modifier
    owner: Id = ""


class UploadStart(_Message, tag="FileTransferStartUpload"):
    """A file is about to be sent; `studio.page.server.uploads` bounds its size."""

    source_component_uuid: Id
    transfer_uuid: Id
    filename: Name
    mime_type: Name
    part_count: Count
    size_bytes: Count


class UploadPart(_Message, tag="FileTransferPart"):
    """A part of a file."""

    source_component_uuid: Id
    transfer_uuid: Id
    part_index: Count
    content: Annotated[bytes, Meta(max_length=LARGEST_PART)]


Message = ControlUpdate | CommandTrigger | Camera | NodeClick | NodeDrag | UploadStart | UploadPart

UNUSED = frozenset(
    {
        "GetRenderResponseMessage",
        "GuiButtonHoldMessage",
        "GuiFormDirtyMessage",
        "GuiFormSubmitMessage",
        "ScenePointerMessage",
        "ShareUrlDisconnect",
        "ShareUrlRequest",
        "TransformControlsDragEndMessage",
        "TransformControlsDragStartMessage",
        "TransformControlsUpdateMessage",
    }
)
"""Types that the library handles and the page does not need; dropped."""

_DECODER = msgspec.msgpack.Decoder(Message)
_ENCODER = msgspec.msgpack.Encoder()


def decode(raw: bytes) -> Message:
    """A message as the browser encodes it.

    Raises:
        msgspec.MsgspecError: it is none of the types above, or a field is out of bounds.
    """
    return _DECODER.decode(raw)


def encode(message: Message) -> bytes:
    """For the viewer library."""
    return _ENCODER.encode(message)
