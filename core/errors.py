"""The error that is shown to the user."""

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST_MESSAGE = 2000
"""Characters of a message, whatever was given."""

_LONGEST_NAME = 80  # characters; nothing longer is near to a name


class UserError(ValueError):
    """Bad input, with a message for the user who gave it.

    The message says what was wrong, what was given, what is allowed and where. The page shows it
    unchanged; the command line prints it and exits with status 2. Every other exception is a
    defect of the program. The middle of a message longer than `LONGEST_MESSAGE` is left out.
    """

    def __init__(self, message: str):
        if len(message) > LONGEST_MESSAGE:
            half = LONGEST_MESSAGE // 2
            message = f"{message[:half]} ... {message[-half:]}"
        super().__init__(message)


def allowed(given: object, names: Iterable[str]) -> str:
    """`Allowed: ...`, the names nearest to what was given first."""
    everything = list(names)
    near = get_close_matches(str(given)[:_LONGEST_NAME], everything, n=3, cutoff=0.5)
    rest = [name for name in everything if name not in near]
    return "Allowed: " + (", ".join(near + rest) or "none")
