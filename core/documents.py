"""Typed values from documents (JSON or TOML), with errors that say what is allowed.

msgspec checks the values against a type, such as a `Struct` that forbids unknown fields and bounds
its numbers with `Annotated[int, Meta(ge=1, le=100)]`. Its errors name the place and what was
expected there; the ones raised here also show what was given and which names are known.
"""

import re
import sys
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, inspect

from core.errors import UserError, allowed
from core.quoting import shown

LONGEST_SHOWN = 60
"""Characters of a wrong value that an error shows."""

Share = Annotated[float, Meta(ge=0, le=1)]
Positive = Annotated[float, Meta(gt=0, le=10**6)]
NotNegative = Annotated[float, Meta(ge=0, le=10**6)]
Weight = Annotated[float, Meta(ge=-(10**6), le=10**6)]

T = TypeVar("T")


def typed(values: Any, kind: type[T], prefix: str = "") -> T:
    """Values of a document as an instance of a type; numbers are not made from text.

    Args:
        values: what a JSON or TOML reader gave.
        kind: a type that msgspec knows.
        prefix: stands before the field in errors, `regions.A1.` for instance.

    Raises:
        UserError: `<prefix><field>: <what is wrong>`.
    """
    try:
        return msgspec.convert(values, kind)
    except msgspec.ValidationError as error:
        raise UserError(prefix + _explained(str(error), values, kind)) from error
    except OverflowError as error:  # an integer of hundreds of digits where a number may stand
        raise UserError(f"{prefix.rstrip('.: ')}: a number is too large") from error


def _explained(message: str, values: Any, kind: type) -> str:
    """What is wrong, from msgspec's message (it ends with the place), the values and their type."""
    expected = inspect.type_info(kind)
    place = re.search(r" - at `\$([^`]*)`$", message)
    path = place[1].removeprefix(".") if place else ""
    try:
        expected, given = _at(path, expected, values)
    except (LookupError, TypeError):  # the place is a part of an unknown field's name
        path, given = "", values
    if isinstance(expected, inspect.StructType) and isinstance(given, dict):
        return _wrong_field(expected, given, f"{path}." if path else "")
    where = f"{path}: " if path else ""
    too_large = isinstance(given, int) and abs(given) > sys.float_info.max
    problem = ", a number too large to use: it" if too_large else ""
    return f"{where}{_repr(given)}{problem} must be {_wanted(expected)}"


def _repr(value: Any) -> str:
    try:
        return shown(repr(value), LONGEST_SHOWN)
    except (RecursionError, ValueError):  # nested too deeply, or an integer of too many digits
        return f"this {type(value).__name__}"


def _at(path: str, expected: inspect.Type, given: Any) -> tuple[inspect.Type, Any]:
    """Type and value at a place such as `algorithm.hidden[1]`."""
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path):
        match expected:
            case inspect.StructType(fields=fields):
                expected = {field.encode_name: field.type for field in fields}[name]
                given = given[name]
            case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item):
                expected, given = item, given[int(index)]
    return expected, given


def _wrong_field(expected: inspect.StructType, given: dict[str, Any], prefix: str) -> str:
    """The first field that is not known, or the first that is missing."""
    names = [field.encode_name for field in expected.fields]
    for name in given:
        if name not in names:
            return f"{prefix}{shown(name)}: unknown. {allowed(name, names)}"
    missing = next(
        f.encode_name for f in expected.fields if f.required and f.encode_name not in given
    )
    return f"{prefix}{missing}: this field is missing"


def _wanted(expected: inspect.Type) -> str:
    """A type in words."""
    match expected:
        case inspect.IntType():
            return "an integer" + _range(expected)
        case inspect.FloatType():
            return "a number" + _range(expected)
        case inspect.StrType():
            return "text"
        case inspect.BoolType():
            return "true or false"
        case inspect.NoneType():
            return "null"
        case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item):
            most = "" if expected.max_length is None else f" of at most {expected.max_length}"
            return f"a list{most}, each entry {_wanted(item)}"
        case inspect.DictType() | inspect.StructType():
            return "a table"
        case inspect.LiteralType(values=values):
            return " or ".join(map(repr, values))
        case inspect.UnionType(types=types):
            return " or ".join(map(_wanted, types))
    return f"a {type(expected).__name__}"


def _range(number: inspect.IntType | inspect.FloatType) -> str:
    """The bounds of a number: ` from 1 to 100`, or one side of them."""
    if number.ge is not None and number.le is not None:
        return f" from {number.ge} to {number.le}"
    bounds = {"above": number.gt, "at least": number.ge, "below": number.lt, "at most": number.le}
    text = " and ".join(f"{word} {bound}" for word, bound in bounds.items() if bound is not None)
    return f" of {text}" if text.startswith("at ") else f" {text}" if text else ""
