"""Undo and redo of immutable states."""

from typing import Generic, NamedTuple, TypeVar

State = TypeVar("State")

CAPACITY = 200
"""Number of steps that can be undone; older ones are dropped."""


class Step(NamedTuple, Generic[State]):
    """One step: its label, and the state before or after it."""

    label: str
    state: State


class History(Generic[State]):
    """The current state, the steps that led to it and those that were undone.

    Attributes:
        present: the current state.
        revision: counts the changes of `present` by edits, undo and redo.
    """

    def __init__(self, state: State) -> None:
        self.present = state
        self.revision = 0
        self._past: list[Step[State]] = []
        self._future: list[Step[State]] = []
        self._gesture: str | None = None

    @property
    def undo_label(self) -> str | None:
        """What `undo` would undo; None if nothing."""
        return self._past[-1].label if self._past else None

    @property
    def redo_label(self) -> str | None:
        """What `redo` would redo; None if nothing."""
        return self._future[-1].label if self._future else None

    def record(self, label: str, state: State, gesture: str | None = None) -> bool:
        """Go to a new state.

        Args:
            label: description of the step, for the menus.
            state: the new state; an equal one is not a step.
            gesture: consecutive edits of one gesture (a drag, a burst of typing) are one step; a
                gesture that ends where it began is not a step.

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
        """Undo the last step; returns its label, None if there is none."""
        return self._shift(self._past, self._future)

    def redo(self) -> str | None:
        """Redo the step that was last undone; returns its label, None if there is none."""
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
