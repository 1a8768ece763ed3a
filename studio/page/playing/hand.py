"""A hand that takes the robot from where it plays and puts it somewhere else."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from core.task.moving import move_robot
from scenes.arena import Arena
from studio.page.analyst import Analyst
from studio.page.asking import Move
from studio.page.editing.editor import Phase, Point
from studio.page.playing.player import Player
from studio.runs.recording import Recording

LEAST = 0.05
"""Shorter drags are clicks and move nothing, in robot lengths."""


@dataclass(frozen=True, eq=False)
class Held:
    """The robot, held somewhere else than its rollout says."""

    recording: Recording
    step: int
    """The step at which it will stand there, the next one of the rollout."""
    grabbed: np.ndarray  # [3] where the pointer took it [m]
    origin: np.ndarray  # [3] where it was then [m]
    position: np.ndarray  # [3] where it is [m], z = 0 for planar robots
    state: np.ndarray  # [n]
    playing: bool
    """Whether the rollout was playing when it was taken."""
    released: bool = False
    """Whether it was let go; it stays until the answer has come."""


class Hand:
    """Moves the robot of the rollout on screen; read `held`."""

    def __init__(self, player: Player, analyst: Analyst, arena: Callable[[], Arena]) -> None:
        self._player, self._analyst, self._arena = player, analyst, arena
        self.held: Held | None = None

    def can_take(self) -> bool:
        """Whether there is a rollout with a step to come."""
        recording = self._player.recording
        return recording is not None and int(self._player.position) + 1 < recording.steps

    def drag(self, phase: Phase, start: Point, end: Point) -> None:
        """Take the robot, move it as the pointer moves from start to end [m], let it go.

        Raises:
            UserError: nobody can answer for the rollout shown.
        """
        if phase == "start":
            self._take(start)
        held = self.held
        if held is None or held.released or held.recording is not self._player.recording:
            self.held = None
            return
        self.held = held = _carried(held, np.asarray(end) - held.grabbed, self._arena())
        if phase != "end":
            return
        far = LEAST * held.recording.task.robot.length
        if np.linalg.norm(held.position - held.origin) < far:
            self.held = None
            if held.playing:
                self._player.toggle()
            return
        self.held = replace(held, released=True)
        try:
            self._analyst.ask_move(Move(held.recording, held.step, held.state))
        except Exception:
            self.held = None
            raise

    def tick(self, idle: bool) -> None:
        """Let go of what has been answered, or of what is no longer shown.

        Args:
            idle: whether every request was answered, and all answers are on screen.
        """
        held = self.held
        if held is None:
            return
        if held.released and idle or held.recording is not self._player.recording:
            self.held = None

    def _take(self, point: Point) -> None:
        recording = self._player.recording
        if recording is None or not self.can_take():
            self.held = None
            return
        now, playing = int(self._player.position), self._player.playing
        self._player.seek(now)
        self._analyst.prepare_moves()
        here = recording.positions[now]
        self.held = Held(
            recording, now + 1, np.array(point), here, here, recording.states[now], playing
        )


def _carried(held: Held, offset: np.ndarray, arena: Arena) -> Held:
    """The robot, carried from where it was taken, within the arena."""
    robot = held.recording.task.robot
    low, high = np.array(arena).T
    size = robot.position_size
    wanted = np.clip((held.origin + offset)[:size], low, high).astype(np.float32)
    before = jnp.asarray(held.recording.states[held.step], jnp.float32)
    state, reached = move_robot(before, jnp.asarray(wanted), robot=robot)
    position = np.zeros(3)
    position[:size] = np.asarray(reached)
    return replace(held, position=position, state=np.asarray(state))
