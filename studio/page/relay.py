"""Hands what the analyst finds out to player and gallery; drops what comes too late."""

from studio.page.analyst import Analyst, Answer
from studio.page.playing.gallery import Gallery
from studio.page.playing.player import Player
from studio.page.trainer import Training


class Relay:
    """Asks for a plan whenever weights have come to rest, and hands answers on."""

    def __init__(self, analyst: Analyst, player: Player, gallery: Gallery) -> None:
        self._analyst, self._player, self._gallery = analyst, player, gallery
        self._shown: Training | None = None
        self._received: Answer | None = None

    def forget(self) -> None:
        """Treat the next weights as new."""
        self._shown = None

    def pass_on(self, training: Training, stale: str) -> None:
        """Give the analyst the newest weights and the player the newest rollout.

        Args:
            training: whose weights answer for the scene shown.
            stale: why they do not, empty if they do.
        """
        analyst = self._analyst
        analyst.stale = stale
        analyst.observe(training)
        if self._deserves_a_plan(training):
            analyst.ask(asked=False)
        self._shown = training
        answer, sample = analyst.answer, analyst.sample
        if answer is not self._received:
            self._received = answer
            if answer is None:
                self._player.load(None)
            elif answer.subject.training is training.identity:
                moved = answer.moved
                self._player.load(answer.recordings[0], 0 if moved is None else moved.step)
                if answer.asked and moved is None:
                    self._gallery.add(answer.recordings[0])
        if sample is not None and sample.subject.training is training.identity:
            self._gallery.sample = sample.recordings

    def _deserves_a_plan(self, training: Training) -> bool:
        """Whether weights have just come to rest, and nobody has asked them for anything yet."""
        shown, received = self._shown, self._received
        if training.weights is None or training.busy or self._analyst.stale:
            return False
        if received is not None and received.asked:
            if received.subject.training is training.identity:
                return False
        if shown is None or shown.identity is not training.identity:
            return True
        return shown.phase is not training.phase
