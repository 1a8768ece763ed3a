"""Reads the English of `core.stl.english` back into formulas, with times in steps.

Written from the rules that the sentences promise to a person, not from the code that writes them.
"""

import re
from collections.abc import Callable

from core.stl import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    conjunction,
)

STEPS = r"(\d+) steps?"
SPAN = r"(?:(\d+) to )?(\d+) steps?"


def read_english(sentences: tuple[str, ...]) -> Formula:
    """The conjunction of the sentences."""
    return conjunction(_Reader(sentence).sentence() for sentence in sentences)


class _Reader:
    def __init__(self, text: str):
        self._text = text[0].lower() + text[1:]
        self._at = 0

    def sentence(self) -> Formula:
        formula = self._clause(True)
        self._expect(r"\.\Z")
        return formula

    def _take(self, pattern: str) -> re.Match[str] | None:
        match = re.compile(pattern).match(self._text, self._at)
        if match:
            self._at = match.end()
        return match

    def _expect(self, pattern: str) -> re.Match[str]:
        match = self._take(pattern)
        assert match, f"{pattern!r} expected: {self._text[self._at :]!r} of {self._text!r}"
        return match

    def _clause(self, absolute: bool) -> Formula:
        """A clause; times of the episode may stand in it only if it counts from its start."""
        for rule in (self._group, self._condition, self._until, self._every, self._stay):
            formula = rule(absolute)
            if formula is not None:
                return formula
        if absolute and self._take("at step 0 be "):
            return self._chain(self._from_the_start)
        interval = self._moment(absolute)
        if interval is not None:
            self._expect(" ")
            return Eventually(interval, self._clause(False))
        self._expect("be ")
        return self._chain(lambda: self._clause(absolute))

    def _chain(self, clause: Callable[[], Formula]) -> Formula:
        """A place, and what else counts from the same moment."""
        place = self._place()
        if self._take(", and "):
            return And((place, clause()))
        return place

    def _from_the_start(self) -> Formula:
        """A clause after `at step 0`: a time of the episode, and a moment that others follow."""
        start = self._at
        try:
            return self._clause(True)
        except AssertionError:
            self._at = start
            return self._clause(False)

    def _moment(self, absolute: bool) -> Interval | None:
        if absolute:
            if match := self._take(r"between step (\d+) and step (\d+)"):
                return Interval(int(match[1]), int(match[2]))
            if match := self._take(r"at step (\d+)"):
                return Interval(int(match[1]), int(match[1]))
        if self._take("at that moment"):
            return Interval(0, 0)
        if match := self._take(f"{SPAN} later"):
            return Interval(int(match[1] or match[2]), int(match[2]))
        return None

    def _group(self, absolute: bool) -> Formula | None:
        kind = self._take(r"(do all of|do at least one of|do both or neither of|never do) \(")
        if not kind:
            return None
        parts = [self._clause(absolute)]
        while self._take("; "):
            parts.append(self._clause(absolute))
        self._expect(r"\)")
        match kind[1]:
            case "never do":
                (part,) = parts
                return Not(part)
            case "do all of":
                return And(tuple(parts))
            case "do at least one of":
                return Or(tuple(parts))
        left, right = parts
        return Or((And((left, right)), And((Not(left), Not(right)))))

    def _condition(self, absolute: bool) -> Formula | None:
        if not self._take("if "):
            return None
        if self._take(r"this is done \("):
            left = self._clause(absolute)
            self._expect(r"\)")
        else:
            left = self._place()
            if absolute:
                self._expect(" at step 0")
        self._expect(" then ")
        return Implies(left, self._clause(absolute))

    def _until(self, absolute: bool) -> Formula | None:
        start, end = self._at, " up to and including "
        every = self._take("at every moment up to and including ")
        if every:
            interval = self._end(absolute)
            self._expect(r" do \(")
            left = self._clause(False)
            self._expect(r"\)")
        elif self._take(r"stay (?!\d)"):
            left = self._place()
            self._expect(end)
            interval = self._end(absolute)
        else:
            self._at = start
            return None
        self._expect(", and then, at that moment, ")
        return Until(interval, left, self._clause(False))

    def _end(self, absolute: bool) -> Interval:
        if absolute:
            match = self._expect(r"a moment between step (\d+) and step (\d+)|step (\d+)")
            return Interval(int(match[1] or match[3]), int(match[2] or match[3]))
        if self._take("that moment"):
            return Interval(0, 0)
        self._expect("the moment ")
        interval = self._moment(False)
        assert interval is not None
        return interval

    def _window(self, absolute: bool) -> Interval:
        if absolute:
            match = self._expect(r"from step (\d+) to step (\d+)")
        else:
            match = self._expect(r"from (\d+) to (\d+) steps? later")
        return Interval(int(match[1]), int(match[2]))

    def _every(self, absolute: bool) -> Formula | None:
        if not self._take("at every moment (?=from )"):
            return None
        window = self._window(absolute)
        self._expect(": ")
        return Always(window, self._clause(False))

    def _stay(self, absolute: bool) -> Formula | None:
        if not absolute and (match := self._take(f"stay {STEPS} ")):
            return Always(Interval(0, int(match[1])), self._place())
        if not self._take("(?=from )"):
            return None
        window = self._window(absolute)
        self._expect(" stay ")
        return Always(window, self._place())

    def _place(self) -> Formula:
        if self._take("not "):
            return Not(self._part())
        if self._take("either "):
            left = self._part()
            self._expect(" or ")
            right = self._part()
            self._expect(" but not both")
            return And((Or((left, right)), Not(And((left, right)))))
        parts = [self._part()]
        if self._take(" exactly when "):
            right = self._part()
            return And((Implies(parts[0], right), Implies(right, parts[0])))
        if self._take(" if "):
            return Implies(self._part(), parts[0])
        while self._take(r", (?!and )"):
            parts.append(self._part())
        if word := self._take(" (and|or) "):
            parts.append(self._part())
            return (And if word[1] == "and" else Or)(tuple(parts))
        (part,) = parts
        return part

    def _part(self) -> Formula:
        if self._take(r"\("):
            inner = self._place()
            self._expect(r"\)")
            return inner
        if word := self._take("anywhere|nowhere"):
            return Constant(word[0] == "anywhere")
        match = self._expect(r'(in|outside) (\w+|"[^"]*")')
        atom = Atom(match[2].strip('"'))
        return atom if match[1] == "in" else Not(atom)
