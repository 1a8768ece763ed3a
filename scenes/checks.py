"""What names, numbers and colours of a scene may be."""

import re

from core.errors import UserError

LARGEST_COORDINATE = 1e3
"""Largest magnitude of a coordinate and largest size in [m]; float32 stays exact to 0.1 mm."""

SMALLEST_SIZE = 1e-6
"""Smallest size in [m]; a smaller region vanishes in float32."""

LONGEST_NAME = 40
"""Largest number of characters of a region's name."""


class SceneError(UserError):
    """A scene, a region or a scene file that cannot be used."""


def check_name(name: object) -> None:
    """Refuse names that a formula cannot quote: empty, long, padded, with quotes or controls."""
    if not isinstance(name, str) or not name:
        raise SceneError(f"name: {name!r} must be non-empty text")
    if len(name) > LONGEST_NAME:
        raise SceneError(f"name: {name[:LONGEST_NAME]!r}... is longer than {LONGEST_NAME}")
    if not name.isprintable() or name != name.strip() or re.search(r"[\"'`\\]", name):
        raise SceneError(
            f"name: {name!r} must be printable, without quotes, backslashes or spaces at the ends"
        )


def is_color(color: object) -> bool:
    """Whether a value is text of the form `#rrggbb`."""
    return isinstance(color, str) and re.fullmatch(r"#[0-9a-fA-F]{6}", color) is not None


def numbers(field: str, values: object, names: tuple[str, ...], kind: str) -> tuple[float, ...]:
    """Check that there is one finite number per name and return them as floats."""
    expected = f"a {kind} needs ({', '.join(names)}) in [m]"
    if not isinstance(values, list | tuple):
        raise SceneError(f"{field}: {values!r} is not a list of numbers; {expected}")
    if len(values) != len(names):
        raise SceneError(f"{field}: {list(values)} has {len(values)} numbers; {expected}")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SceneError(f"{field}: {value!r} is not a number; {expected}")
        if not abs(value) <= LARGEST_COORDINATE:  # NaN compares false
            given = repr(value) if isinstance(value, float) else "a number"
            raise SceneError(
                f"{field}: {given} must be finite and at most {LARGEST_COORDINATE:g} m"
            )
    return tuple(float(value) for value in values)
