"""What a person is told when a formula cannot be read."""

from core.errors import UserError

# Characters of a source line that the caret text shows.
_CARET_WIDTH = 76


class FormulaError(UserError):
    """A formula that cannot be read.

    Attributes:
        problem: what is wrong, without the place.
        expected: what could have stood there, in words; empty where that would not help.
        hint: how to put it right; may be empty.
        offset: position in the text, in characters from 0.
        line: from 1.
        column: in characters from 1.
        caret: the line at fault (an excerpt of a long one) and a caret below the place.
    """

    def __init__(self, problem: str, text: str, offset: int, *, expected: str = "", hint: str = ""):
        self.problem = problem
        self.expected = expected
        self.hint = hint
        self.offset = min(max(offset, 0), len(text))
        start = text.rfind("\n", 0, self.offset) + 1
        self.line = text.count("\n", 0, start) + 1
        self.column = self.offset - start + 1
        self.caret = _caret(text[start:].split("\n", 1)[0], self.column - 1)
        super().__init__(self._message())

    def _message(self) -> str:
        sentence = f"line {self.line}, column {self.column}: {self.problem}"
        if self.expected:
            sentence += f"; expected {self.expected}"
        if self.hint:
            sentence += f" ({self.hint})"
        return f"{sentence}\n{self.caret}"


def _caret(line: str, position: int) -> str:
    """Two lines: an excerpt of the source line, and a caret below the position in it."""
    line = "".join(character if character.isprintable() else " " for character in line)
    first = max(0, position - _CARET_WIDTH // 2) if len(line) > _CARET_WIDTH else 0
    last = first + _CARET_WIDTH
    head = "..." if first > 0 else ""
    tail = "..." if last < len(line) else ""
    return f"{head}{line[first:last]}{tail}\n{' ' * (len(head) + position - first)}^"
