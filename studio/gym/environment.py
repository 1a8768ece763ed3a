"""A scene as a Gymnasium environment, paid with the formula's robustness at the end."""

from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces

from core.compilation import program
from core.errors import UserError
from core.evaluation import trace_robustness
from core.rollout import start_states
from core.task.physics import physics_of
from core.task.problem import Problem, atom_margins
from core.task.protocols import Array
from scenes import Scene, load_task
from studio.runs.tasks import build_task, initial_state

BROKEN = -10.0
"""Reward of a simulation that breaks down, in units of the robot's length."""


class StlEnv(gymnasium.Env):
    """One robot, its regions and one formula of Signal Temporal Logic.

    **Action** `Box(-1, 1, (m,), float32)`: the robot's own, as docs/robots says (velocities of
    `linear`, forces of `quadrotor`, a waypoint of `ant`, ...).

    **Observation** `Box(-inf, inf, (n + 1 + A,), float32)`:

    ==========  ===============================================================================
    n entries   the state, in the units of `robot.state_names`
    1 entry     the share of the episode that is over, 0 at the start and 1 at the end
    A entries   margin of each region in the scene's order [m]: >= 0 inside, minus the distance
                outside; of one that moves, where it is at the time
    ==========  ===============================================================================

    What has been visited is not observed: a formula's progress is for the learner to remember.

    **Reward** 0 until the last step, which pays the robustness of the formula on the whole trace
    [m], by the exact semantics: it is >= 0 exactly if the formula is satisfied. A simulation that
    breaks down ends at once and pays `BROKEN` lengths of the robot.

    **End** after max(horizon of the scene, horizon of the formula) steps, *terminated*: nothing
    lies beyond. `info` then has `robustness` and `satisfied`. An episode is never truncated.

    **Start** uniform in the scene's initial set, at rest, or with `reset(options={"position":
    (x, y)})` at that position.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        task: str | None = None,
        *,
        scene: Scene | None = None,
        formula: str | None = None,
        render_mode: None = None,
    ):
        """Ground a shipped task or a scene.

        Args:
            task: name of a shipped task, such as `linear-08`.
            scene: a scene instead of it.
            formula: another formula for it.
            render_mode: none is offered.

        Raises:
            UserError: no such task, or a formula that is malformed, does not decompose or cannot
                be carried out.
        """
        if (task is None) == (scene is None):
            raise UserError("give either a task, such as 'linear-08', or a scene")
        self.render_mode = render_mode
        self.scene = load_task(str(task)) if scene is None else scene
        self.task = build_task(self.scene, formula)
        self._physics = physics_of(self.task.robot)
        self._regions = len(self.scene.regions)
        robot = self.task.robot
        seen = robot.state_size + 1 + self._regions
        self.action_space = spaces.Box(-1.0, 1.0, (robot.action_size,), np.float32)
        self.observation_space = spaces.Box(-np.inf, np.inf, (seen,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode.

        Raises:
            UserError: an option that is unknown, or a position of a wrong size.
        """
        super().reset(seed=seed)
        self._state = self._start(options or {})
        self._trace = [np.asarray(_margins(self.task.problem, self._state, self._clock(0)))]
        return self._observed(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Act for one step of the robot."""
        given = jnp.asarray(action, jnp.float32)
        clock = self._clock(len(self._trace))
        if self._physics is None:
            self._state, margins = _after(self.task.problem, self._state, given, clock)
        else:
            after = self._physics.step(np.asarray(self._state)[None], np.asarray(given)[None])[0]
            self._state = jnp.asarray(after, jnp.float32)
            margins = _margins(self.task.problem, self._state, clock)
        self._trace.append(np.asarray(margins))
        if not np.isfinite(np.asarray(self._state)).all():
            return self._ended(-np.inf)
        if len(self._trace) <= self.task.horizon:
            return self._observed(), 0.0, False, False, {}
        return self._ended(float(trace_robustness(self.task, np.stack(self._trace)[:, None])[0]))

    def _clock(self, step: int) -> Array | None:
        """The step [], for regions that move; None for those that stand."""
        return jnp.float32(step) if self.scene.moving else None

    def _start(self, options: dict[str, Any]) -> Array:
        unknown = sorted(set(options) - {"position"})
        if unknown:
            raise UserError(f"options: unknown {unknown[0]!r}. Allowed: position")
        if "position" not in options:
            key = jax.random.key(int(self.np_random.integers(2**31)))
            return start_states(self.task.problem, key, count=1)[0]
        given, size = options["position"], self.task.robot.position_size
        try:
            position = np.asarray(given, float)
        except (TypeError, ValueError):
            position = np.empty(0)
        if position.shape != (size,) or not np.isfinite(position).all():
            raise UserError(f"options: position: {given!r} must be {size} numbers [m]")
        return initial_state(self.task, tuple(position.tolist()))

    def _observed(self) -> np.ndarray:
        over = np.float32((len(self._trace) - 1) / self.task.horizon)
        margins = self._trace[-1][: self._regions]
        seen = np.concatenate([np.asarray(self._state), [over], margins])
        return np.nan_to_num(seen).astype(np.float32)

    def _ended(self, robustness: float) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        broken = BROKEN * self.task.robot.length
        reward = robustness if np.isfinite(robustness) else broken
        info = {"robustness": robustness, "satisfied": robustness >= 0}
        return self._observed(), reward, True, False, info


@program
def _after(
    problem: Problem, state: Array, action: Array, clock: Array | None
) -> tuple[Array, Array]:
    """The next state [n] and the margins [A] there, at a step []."""
    following = problem.robot.step(state, action)
    return following, atom_margins(problem, following, clock)[0]


@program
def _margins(problem: Problem, state: Array, clock: Array | None) -> Array:
    return atom_margins(problem, state, clock)[0]
