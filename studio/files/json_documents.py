"""JSON documents that the studio keeps: written atomically, read with errors for a person.

Every document is an object with a `format` (its version). Numbers that JSON does not have (NaN
and the infinities) are written as null.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from core.algorithm import Algorithm
from core.checkpoint import write_atomically
from core.errors import UserError
from core.paper_mode import PaperMode
from core.studio_mode import StudioMode

LARGEST_DOCUMENT = 4_000_000  # bytes
MODES = {"studio": StudioMode, "paper": PaperMode}


class DocumentError(UserError):
    """A document that cannot be written, read or used."""


def write_document(path: Path, values: Mapping[str, Any]) -> None:
    """Write an object as indented JSON.

    Raises:
        DocumentError: the file cannot be written; an earlier one stays.
    """
    text = json.dumps(plain(values), indent=2, ensure_ascii=False, allow_nan=False)
    try:
        write_atomically(path, f"{text}\n".encode())
    except OSError as error:
        raise DocumentError(f"{path}: cannot be written: {error.strerror}") from error


def read_document(path: Path, version: int, required: Mapping[str, type | tuple]) -> dict[str, Any]:
    """Read an object and check its version and the types of the fields that are needed.

    Raises:
        DocumentError: with the file and the field at fault.
    """
    values = _read_object(path)
    if values.get("format") != version:
        raise DocumentError(
            f"{path}: format: {values.get('format')!r} is not known; this program reads "
            f"format {version}"
        )
    for name, kinds in required.items():
        if name not in values:
            raise DocumentError(f"{path}: {name}: this field is missing")
        given = values[name]
        wanted = kinds if isinstance(kinds, tuple) else (kinds,)
        if not isinstance(given, wanted) or (isinstance(given, bool) and bool not in wanted):
            allowed = " or ".join(kind.__name__ for kind in wanted)
            raise DocumentError(f"{path}: {name}: {given!r} must be of type {allowed}")
    return values


def plain(value: Any) -> Any:
    """The value with numbers that JSON does not have replaced by null."""
    if isinstance(value, Mapping):
        return {name: plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def algorithm_document(algorithm: Algorithm) -> dict[str, Any]:
    """All hyper-parameters as JSON values."""
    return {**asdict(algorithm), "mode": asdict(algorithm.mode)}


def read_algorithm(values: Mapping[str, Any], mode: str, where: str) -> Algorithm:
    """Hyper-parameters from `algorithm_document`; those that it lacks have their defaults.

    Raises:
        DocumentError: unknown or ill-typed hyper-parameters.
    """
    if mode not in MODES:
        raise DocumentError(f"{where}: mode: unknown {mode!r}. Available: {sorted(MODES)}")
    rest = {name: value for name, value in values.items() if name != "mode"}
    reward = values.get("mode")
    if not isinstance(reward, dict):
        raise DocumentError(f"{where}: algorithm.mode: this table is missing")
    rewards = _filled(MODES[mode], reward, f"{where}: algorithm.mode")
    return _filled(Algorithm, rest, f"{where}: algorithm", mode=rewards)


def _filled(kind: type, values: Mapping[str, Any], where: str, **ready: Any) -> Any:
    """An instance of a flat dataclass of numbers and tuples of numbers."""
    template = kind()
    names = [field.name for field in fields(kind) if field.name not in ready]
    unknown = sorted(set(values) - set(names))
    if unknown:
        raise DocumentError(f"{where}.{unknown[0]}: unknown. Available: {', '.join(names)}")
    given = {n: _like(getattr(template, n), values[n], f"{where}.{n}") for n in values}
    return kind(**given, **ready)


def _like(example: Any, given: Any, where: str) -> Any:
    """A value of the type of an example."""
    if isinstance(example, tuple) and isinstance(given, list):
        return tuple(_like(1, entry, where) for entry in given)
    fits = type(given) is type(example) or (type(example) is float and type(given) is int)
    if isinstance(example, tuple) or not fits or not math.isfinite(given):
        raise DocumentError(f"{where}: {given!r} must be of type {type(example).__name__}")
    return type(example)(given)


def _read_object(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > LARGEST_DOCUMENT:
            raise DocumentError(f"{path}: larger than {LARGEST_DOCUMENT:,} bytes")
        values = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DocumentError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:  # JSONDecodeError, UnicodeDecodeError
        raise DocumentError(f"{path}: not valid JSON: {error}") from error
    except RecursionError as error:
        raise DocumentError(f"{path}: nested too deeply") from error
    if not isinstance(values, dict):
        raise DocumentError(f"{path}: must be an object {{...}}")
    return values
