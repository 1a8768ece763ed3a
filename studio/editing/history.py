"""Undo and redo of immutable states."""

from typing import Generic, NamedTuple, TypeVar

State = TypeVar("State")

CAPACITY = 200
"""Steps that can be undone; the oldest are forgotten."""


class Step(NamedTuple, Generic[State]):
    """One step: what was done, and the state on the other side of it."""

    label: str
    state: State


class History(Generic[State]):
    """A present state, the steps that led to it and those that were undone.

    Attributes:
        present: the state now.
        revision: counts the changes of `present`, by edits, undo and redo alike.
    """

    def __init__(self, state: State) -> None:
        self.present = state
        self.revision = 0
        self._past: list[Step[State]] = []
        self._future: list[Step[State]] = []
        self._gesture: str | None = None

    @property
    def undo_label(self) -> str | None:
        """What `undo` would take back; None if nothing."""
        return self._past[-1].label if self._past else None

    @property
    def redo_label(self) -> str | None:
        """What `redo` would do again; None if nothing."""
        return self._future[-1].label if self._future else None

    def record(self, label: str, state: State, gesture: str | None = None) -> bool:
        """Go to a new state.

        Args:
            label: what is done, for the menus.
            state: the new state; an equal one is no step.
            gesture: consecutive edits of one gesture (a drag, a spell of typing) are one step; a
                gesture that ends where it began is none.

        Returns:
            Whether the state changed.
        """
        merged = gesture is not None and gesture == self._gesture
        if state == self.present:
            self._gesture = self._gesture if merged else None
            return False
        self._gesture = gesture
        if not merged:
            self._past.append(Step(label, self.present))
            del self._past[:-CAPACITY]
        self._future.clear()
        self._go_to(state)
        if merged and self._past[-1].state == state:
            self._past.pop()
            self._gesture = None
        return True

    def undo(self) -> str | None:
        """Take the last step back; returns its label, None if there is none."""
        return self._shift(self._past, self._future)

    def redo(self) -> str | None:
        """Do the step again that was taken back last; returns its label, None if there is none."""
        return self._shift(self._future, self._past)

    def _shift(self, source: list[Step[State]], target: list[Step[State]]) -> str | None:
        self._gesture = None
        if not source:
            return None
        step = source.pop()
        target.append(Step(step.label, self.present))
        self._go_to(step.state)
        return step.label

    def _go_to(self, state: State) -> None:
        self.present = state
        self.revision += 1
