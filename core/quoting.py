"""What a person typed, as it can stand inside a message: short, on one line, no control marks."""

LONGEST_NAME = 40  # characters, escapes included
LONGEST_FORMULA = 90


def shown(text: str, longest: int = LONGEST_NAME) -> str:
    r"""Escape what cannot be printed (`\x1b`, `\n`) and leave out the middle of a long text.

    Args:
        text: a name or a formula, of any length.
        longest: characters of the result.
    """
    half = (longest - 5) // 2
    if len(text) > 2 * longest:  # do not escape what will be left out
        text = f"{text[:longest]}{text[-longest:]}"
        escaped = _escaped(text)
        return f"{escaped[:half]} ... {escaped[-half:]}"
    escaped = _escaped(text)
    return escaped if len(escaped) <= longest else f"{escaped[:half]} ... {escaped[-half:]}"


def quoted(text: str, longest: int = LONGEST_NAME) -> str:
    """The text as `shown`, in single quotes, or in double quotes where it has single ones."""
    mark = '"' if "'" in text else "'"
    return f"{mark}{shown(text, longest)}{mark}"


def listed(names: list[str], most: int = 12) -> str:
    """`A, B and 3 more`."""
    more = len(names) - most
    return ", ".join(map(shown, names[:most])) + (f" and {more} more" if more > 0 else "")


def _escaped(text: str) -> str:
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
