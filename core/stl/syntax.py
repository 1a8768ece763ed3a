"""Syntax tree of Signal Temporal Logic formulas.

Nodes are frozen and compare by structure; `span` (where the node stood in its source text) is
left out of the comparison. Intervals are closed and in integer steps relative to the time at
which the formula is evaluated.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple


class Span(NamedTuple):
    """Half-open range of character offsets in the source text."""

    start: int
    stop: int


class Interval(NamedTuple):
    """Closed interval [start, stop] in steps, 0 <= start <= stop."""

    start: int
    stop: int


@dataclass(frozen=True, kw_only=True)
class Formula:
    """Base of all nodes."""

    span: Span | None = field(default=None, compare=False, repr=False)


def _check_operands(node: "And | Or") -> None:
    if len(node.operands) < 2:
        raise ValueError(f"{type(node).__name__} needs at least two operands: {node.operands}")


@dataclass(frozen=True)
class Constant(Formula):
    """`true` or `false`."""

    value: bool


@dataclass(frozen=True)
class Atom(Formula):
    """A named predicate: satisfied where its margin is >= 0."""

    name: str
    place: bool = field(default=True, compare=False, repr=False)
    """Whether it is a region, not a predicate of the robot's state."""


@dataclass(frozen=True)
class Not(Formula):
    """Negation."""

    operand: Formula


@dataclass(frozen=True)
class And(Formula):
    """Conjunction of two or more operands."""

    operands: tuple[Formula, ...]

    def __post_init__(self):
        _check_operands(self)


@dataclass(frozen=True)
class Or(Formula):
    """Disjunction of two or more operands."""

    operands: tuple[Formula, ...]

    def __post_init__(self):
        _check_operands(self)


@dataclass(frozen=True)
class Implies(Formula):
    """`left -> right`, right-associative."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Eventually(Formula):
    """`F_[a:b] operand`: at some step of the interval."""

    interval: Interval
    operand: Formula


@dataclass(frozen=True)
class Always(Formula):
    """`G_[a:b] operand`: at every step of the interval."""

    interval: Interval
    operand: Formula


@dataclass(frozen=True)
class Until(Formula):
    """`left U_[a:b] right`: left holds from now up to and including a step where right holds."""

    interval: Interval
    left: Formula
    right: Formula


def conjunction(operands: Iterable[Formula], *, span: Span | None = None) -> Formula:
    """All of any number of operands: `true` of none, the operand itself of one."""
    return _join(And, tuple(operands), Constant(True, span=span), span)


def disjunction(operands: Iterable[Formula], *, span: Span | None = None) -> Formula:
    """One of any number of operands: `false` of none, the operand itself of one."""
    return _join(Or, tuple(operands), Constant(False, span=span), span)


def _join(
    node: type[And] | type[Or], operands: tuple[Formula, ...], empty: Formula, span: Span | None
) -> Formula:
    match operands:
        case ():
            return empty
        case (operand,):
            return operand
        case _:
            return node(operands, span=span)


def children(formula: Formula) -> tuple[Formula, ...]:
    """Direct subformulas, left to right."""
    match formula:
        case Constant() | Atom():
            return ()
        case Not(operand=operand) | Eventually(operand=operand) | Always(operand=operand):
            return (operand,)
        case And(operands=operands) | Or(operands=operands):
            return operands
        case Implies(left=left, right=right) | Until(left=left, right=right):
            return (left, right)
    raise TypeError(f"not a formula: {formula!r}")


def with_children(formula: Formula, parts: tuple[Formula, ...]) -> Formula:
    """The same operator over other operands."""
    match formula:
        case Constant() | Atom():
            return formula
        case Not() | Eventually() | Always():
            return replace(formula, operand=parts[0])
        case And() | Or():
            return replace(formula, operands=parts)
        case Implies() | Until():
            return replace(formula, left=parts[0], right=parts[1])
    raise TypeError(f"not a formula: {formula!r}")


def walk(formula: Formula) -> Iterator[Formula]:
    """Every node of the tree, parents first."""
    yield formula
    for child in children(formula):
        yield from walk(child)


def atom_names(formula: Formula) -> tuple[str, ...]:
    """Names of the atoms in order of first appearance."""
    return tuple(dict.fromkeys(node.name for node in walk(formula) if isinstance(node, Atom)))


def with_predicates(formula: Formula, names: Iterable[str]) -> Formula:
    """The formula with the atoms of some names marked as no places."""
    if isinstance(formula, Atom):
        return replace(formula, place=False) if formula.name in names else formula
    parts = tuple(with_predicates(each, names) for each in children(formula))
    return with_children(formula, parts)


def is_state_formula(formula: Formula) -> bool:
    """Whether the formula has no temporal operator, so that one instant decides it."""
    return not any(isinstance(node, Eventually | Always | Until) for node in walk(formula))


def operand_windows(formula: Formula, window: Interval) -> tuple[Interval, ...]:
    """Steps at which each operand is evaluated when the formula is, throughout a window."""
    first, last = window
    match formula:
        case Eventually(interval=(a, b)) | Always(interval=(a, b)):
            return (Interval(first + a, last + b),)
        case Until(interval=(a, b)):
            return (Interval(first, last + b), Interval(first + a, last + b))
    return (window,) * len(children(formula))


def horizon(formula: Formula) -> int:
    """Count the steps after the present one that decide the formula."""
    inner = max((horizon(child) for child in children(formula)), default=0)
    match formula:
        case Eventually(interval=interval) | Always(interval=interval) | Until(interval=interval):
            return interval.stop + inner
        case _:
            return inner
