"""JSON documents that the studio keeps: written atomically, read with errors for a person.

Every document is a `Document` with a `format` (its version). Numbers that JSON does not have (NaN
and the infinities) are written as null.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

import msgspec
from msgspec import Meta

from core.checkpoint import write_atomically
from core.documents import typed
from core.errors import UserError
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.methods import METHODS
from core.methods.tgpo.algorithm import Algorithm
from core.quoting import quoted, shown

LARGEST_DOCUMENT = 4_000_000  # bytes
MODES = {"studio": StudioMode, "paper": PaperMode}

Seed = Annotated[int, Meta(ge=0, le=2**31 - 1)]
Epochs = Annotated[int, Meta(ge=0, le=10**6)]


class DocumentError(UserError):
    """A document that cannot be written, read or used."""


class Document(msgspec.Struct, forbid_unknown_fields=True, kw_only=True, frozen=True):
    """An object of a JSON file; its fields are written in the order of their declaration."""

    format: int


D = TypeVar("D", bound=Document)
T = TypeVar("T")


def write_document(path: Path, document: Document | Mapping[str, Any]) -> None:
    """Write a document, or a table of values, as indented JSON.

    Raises:
        DocumentError: the file cannot be written; an earlier one stays.
    """
    data = msgspec.json.format(msgspec.json.encode(document), indent=2)
    try:
        write_atomically(path, data + b"\n")
    except OSError as error:
        raise DocumentError(f"{path}: cannot be written: {error.strerror}") from error


def read_document(path: Path, version: int, kind: type[D]) -> D:
    """Read a document of a version, and check its fields.

    Raises:
        DocumentError: with the file and the field at fault.
    """
    values = _read_object(path)
    given = values.get("format")
    if given != version or isinstance(given, bool):
        raise DocumentError(
            f"{path}: format: {shown(repr(given))} is not known; this program reads "
            f"format {version}"
        )
    return _typed(values, kind, f"{path}: ")


def plain(value: Any) -> Any:
    """The value with numbers that JSON does not have replaced by null."""
    if isinstance(value, Mapping):
        return {name: plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def algorithm_document(algorithm: Any) -> dict[str, Any]:
    """All hyper-parameters of a method, a dataclass, as JSON values."""
    return asdict(algorithm)


def read_algorithm(values: Mapping[str, Any], method: str, mode: str, where: str) -> Any:
    """Hyper-parameters from `algorithm_document`; those that it lacks have their defaults.

    Raises:
        DocumentError: unknown method or mode, unknown or ill-typed hyper-parameters.
    """
    if method not in METHODS:
        raise DocumentError(
            f"{where}: method: unknown {quoted(method)}. Available: {sorted(METHODS)}"
        )
    if mode not in MODES:
        raise DocumentError(f"{where}: mode: unknown {quoted(mode)}. Available: {sorted(MODES)}")
    kind = METHODS[method].hyper_parameters
    if "mode" not in values:
        raise DocumentError(f"{where}: algorithm.mode: this {_mode_kind(kind)} is missing")
    given, rest = values["mode"], {name: values[name] for name in values if name != "mode"}
    if kind is Algorithm:
        ready = _filled(MODES[mode], given, f"{where}: algorithm.mode")
    elif given == mode:
        ready = given
    else:
        raise DocumentError(f"{where}: algorithm.mode: {quoted(str(given))} must be {mode!r}")
    algorithm = _filled(kind, rest, f"{where}: algorithm", mode=ready)
    try:
        algorithm.check()
    except UserError as error:
        raise DocumentError(f"{where}: algorithm.{error}") from error
    return algorithm


def _mode_kind(kind: type) -> str:
    """What stands for the mode in a document: TGPO's has hyper-parameters of its own."""
    return "table" if kind is Algorithm else "text"


def _filled(kind: type, values: Any, where: str, **ready: Any) -> Any:
    """An instance of a dataclass, its fields but the ones that are ready from a document."""
    prefix = f"{where}." if isinstance(values, dict) else f"{where}: "
    read = _typed(values, _struct_of(kind, frozenset(ready)), prefix)
    return kind(**msgspec.structs.asdict(read), **ready)


@cache
def _struct_of(kind: type, without: frozenset[str]) -> type[msgspec.Struct]:
    """A dataclass as a type of document that refuses unknown fields."""
    hints = get_type_hints(kind, include_extras=True)
    rows = [
        (field.name, hints[field.name]) + (() if field.default is MISSING else (field.default,))
        for field in fields(kind)
        if field.name not in without
    ]
    return msgspec.defstruct(kind.__name__, rows, forbid_unknown_fields=True, kw_only=True)


def _typed(values: Any, kind: type[T], prefix: str) -> T:
    try:
        return typed(values, kind, prefix)
    except UserError as error:
        raise DocumentError(str(error)) from error


def _read_object(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_DOCUMENT + 1)
    except OSError as error:
        raise DocumentError(f"{path}: cannot be read: {error.strerror}") from error
    if len(data) > LARGEST_DOCUMENT:
        raise DocumentError(f"{path}: larger than {LARGEST_DOCUMENT:,} bytes")
    try:
        values = msgspec.json.decode(data)
    except (msgspec.DecodeError, ValueError, OverflowError) as error:
        raise DocumentError(f"{path}: not valid JSON: {_flaw(error, data)}") from error
    except RecursionError as error:
        raise DocumentError(f"{path}: nested too deeply") from error
    if not isinstance(values, dict):
        raise DocumentError(f"{path}: must be a table {{...}}")
    return values


def _flaw(error: Exception, data: bytes) -> str:
    """What a decoder found, with the line where it found it."""
    text = str(error).removeprefix("JSON is malformed: ")
    place = re.search(r" \(byte (\d+)\)$", text)
    if place is None:
        return text
    line = 1 + data.count(b"\n", 0, int(place[1]))
    return f"{text[: place.start()]} in line {line}"
