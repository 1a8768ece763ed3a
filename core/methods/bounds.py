"""Bounds of hyper-parameters, to which documents are held, and the names of the modes."""

from typing import Annotated, Literal

from msgspec import Meta

ModeName = Literal["studio", "paper"]

Width = Annotated[int, Meta(ge=1, le=1024)]
Layers = Annotated[tuple[Width, ...], Meta(max_length=8)]
Size = Annotated[int, Meta(ge=1, le=2**12)]
Many = Annotated[int, Meta(ge=1, le=2**14)]
Count = Annotated[int, Meta(ge=0, le=10**6)]
Steps = Annotated[int, Meta(ge=0, le=10**4)]
LogStd = Annotated[float, Meta(ge=-20, le=20)]
