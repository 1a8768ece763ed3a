"""TGPO as a method: PPO on grounded episodes, schedules drawn uniformly or searched (Alg. 1)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import Program, program, shape_of
from core.evaluation import verdicts
from core.mdp.mode import first_views
from core.memory import require_memory
from core.methods.method import Epoch
from core.methods.networks import Parameters, networks_of
from core.methods.ppo import make_optimizer
from core.methods.tgpo.algorithm import Algorithm, make_algorithm
from core.methods.tgpo.collection import Batch, Sources, collect, collect_layouts
from core.methods.tgpo.controller import TgpoController
from core.methods.tgpo.layouts import epoch_problems
from core.methods.tgpo.learner import LearnerState, epoch_keys, update
from core.methods.tgpo.measured_collection import collect_measured, measured_jobs
from core.methods.tgpo.outcome import outcome_shapes
from core.methods.tgpo.sampler import Elite
from core.task.physics import physics_of
from core.task.problem import Problem, trace_margins
from core.task.protocols import Array, Robot
from core.task.task import Task


@program
def _collect(
    problem: Problem, sources: Sources, key: Array, *, algorithm: Algorithm, steps: int
) -> Batch:
    gather = collect if algorithm.layouts == 1 else collect_layouts
    return gather(problem, sources, key, algorithm=algorithm, steps=steps)


_update = Program(update, fused=True)
_margins = program(trace_margins)


@dataclass(frozen=True)
class TgpoLearner:
    """Learns on one task, or on many layouts of it.

    Attributes:
        task: the grounded task.
        algorithm: hyper-parameters.
        first: the first epoch that it will be asked for.
    """

    task: Task
    algorithm: Algorithm
    first: int = 1

    @property
    def steps_per_epoch(self) -> int:
        """N times L."""
        return self.algorithm.environments * self.task.padded_horizon

    @property
    def evaluation_states(self) -> int:
        """Initial states of an evaluation while training."""
        return self.algorithm.evaluation_states

    @cached_property
    def _problems(self) -> Callable[[int], Problem]:
        return epoch_problems(self.task, self.algorithm, self.first)

    @cached_property
    def _static(self) -> dict[str, Any]:
        return {"algorithm": self.algorithm, "steps": self.task.padded_horizon}

    @cached_property
    def _physics(self) -> Any:
        """The robot's true physics, where epochs are simulated in it."""
        return physics_of(self.task.robot) if self.algorithm.layouts == 1 else None

    @property
    def pace_change(self) -> int | None:
        """The last epoch in the robot's model, where its true physics follows."""
        return None if self._physics is None else self.algorithm.model_epochs

    def fresh(self, seed: int) -> LearnerState:
        """State before the first epoch: made on the host, nothing is compiled."""
        algorithm, formula = self.algorithm, self.task.problem.formula
        networks = networks_of(algorithm, self.task.problem)
        parameters = networks.initial(seed, *self._feature_sizes(), algorithm.log_std)
        low, high = np.asarray(formula.low), np.asarray(formula.high)
        random = np.random.default_rng([seed, 1])

        def schedules(count: int) -> Array:
            drawn = random.integers(low, high + 1, (count, low.size))
            return jnp.asarray(drawn, jnp.int32)

        return LearnerState(
            parameters,
            make_optimizer(algorithm).init(parameters),
            jax.random.fold_in(jax.random.key(seed), 0),  # evaluations fold in other numbers
            schedules(algorithm.count_mcmc),
            Elite(
                schedules(algorithm.elite_capacity),
                jnp.full(algorithm.elite_capacity, -1e6, jnp.float32),
            ),
        )

    def jobs(self, state: LearnerState) -> list[Callable[[], Any]]:
        """Compilations that epochs need.

        Raises:
            UserError: an epoch takes more memory than is free.
        """
        self._problems  # noqa: B018 - layouts are made while programs compile
        problem, sources = self._problem_shapes(), _sources(state)
        key = epoch_keys(state.key).collection
        batch = _collect.shapes(problem, sources, key, **self._static)
        self._require_memory(batch)
        jobs: list[Callable[[], Any]] = [
            partial(_update.compile, state, batch, algorithm=self.algorithm),
        ]
        if self.algorithm.model_epochs > 0 or self._physics is None:
            jobs.insert(0, partial(_collect.compile, problem, sources, key, **self._static))
        if self._physics is not None:
            jobs += measured_jobs(self._physics, problem, sources, key, **self._static)
        if self.algorithm.mode.pays_robustness:
            jobs.append(partial(_margins.compile, self.task.problem, batch.states))
        return jobs

    def epoch(self, state: LearnerState, number: int) -> tuple[LearnerState, Epoch]:
        """One batch and its update, in the robot's model or in its true physics."""
        batch = self.collect(state, number)
        if self.algorithm.mode.pays_robustness:
            batch = self._with_terminal_robustness(batch)
        following = _update(state, batch, algorithm=self.algorithm)
        return following, Epoch(
            float(np.mean(np.asarray(batch.success))),
            float(np.mean(np.asarray(batch.reward))),
            int(batch.diverged),
            np.asarray(following.chains),
        )

    def collect(self, state: LearnerState, number: int) -> Batch:
        """The batch of an epoch."""
        problem, sources = self._problems(number), _sources(state)
        key = epoch_keys(state.key).collection
        if self._physics is None or number <= self.algorithm.model_epochs:
            return _collect(problem, sources, key, **self._static)
        return collect_measured(self._physics, problem, sources, key, **self._static)

    def weight_shapes(self) -> Parameters:
        """Stands for the parameters of the networks."""
        networks = networks_of(self.algorithm, self.task.problem)
        shapes = networks.shapes(*self._feature_sizes())
        if not self.algorithm.outcome:
            return shapes
        return shapes._replace(outcome=outcome_shapes(self.algorithm, self.task.problem))

    def weights(self, state: LearnerState) -> Parameters:
        """Parameters of both networks."""
        return state.parameters

    def with_weights(self, state: LearnerState, weights: Parameters) -> LearnerState:
        """The state with other networks; it explores as at the start, or it would not learn.

        A critic of outcomes is left behind: it knows the policy as it was.
        """
        log_std = jnp.full_like(weights.log_std, self.algorithm.log_std)
        return state._replace(parameters=weights._replace(log_std=log_std, outcome=None))

    def controller(self, weights: Parameters) -> TgpoController:
        """Policy and critic."""
        return TgpoController(self.algorithm, weights)

    def _require_memory(self, batch: Batch) -> None:
        """Refuse a batch that does not fit.

        An epoch holds its batch about four times (collected, flattened, dealt into minibatches)
        and two activations of the widest layer for each of its steps: seen, 1.8 kB a step of
        linear-08, 8.1 GB for 10,000 steps.
        """
        steps, count = self.task.padded_horizon, self.algorithm.environments
        activations = 2 * 4 * max(self.algorithm.hidden, default=0) * self.steps_per_epoch
        require_memory(batch, steps, count, beside=activations)

    def _problem_shapes(self) -> Problem:
        """Stands for the problem, or for the stacked problems, of an epoch."""
        problem, count = self.task.problem, self.algorithm.layouts
        stacked = () if count == 1 else (count,)
        return jax.tree.map(lambda leaf: shape_of(*stacked, *leaf.shape, dtype=leaf.dtype), problem)

    def _feature_sizes(self) -> tuple[int, int]:
        """Numbers of features of the policy and the critic."""
        problem, mode = self.task.problem, self.algorithm.mode
        states = shape_of(1, problem.robot.state_size, dtype=jnp.float32)
        schedules = shape_of(1, *problem.formula.low.shape, dtype=jnp.int32)
        _, view = jax.eval_shape(
            partial(first_views, mode, reserve=self.algorithm.reserve), problem, states, schedules
        )
        return view.policy.shape[-1], view.critic.shape[-1]

    def _with_terminal_robustness(self, batch: Batch) -> Batch:
        """Add the formula's robustness to the last reward of each first episode (Sec. 4.2)."""
        margins = np.asarray(_margins(self.task.problem, batch.states))
        score = verdicts(self.task, np.asarray(batch.states), margins)
        final = np.where(np.isfinite(score), score, 0.0)  # who broke down has been punished
        paid = self.algorithm.mode.scale * jnp.float32(final)
        reward = jnp.asarray(batch.reward).at[self.task.horizon - 1].add(paid)
        return batch._replace(reward=reward, robustness=jnp.asarray(score, jnp.float32))


@dataclass(frozen=True)
class Tgpo:
    """TGPO or TGPO*; the preset tells them apart."""

    name: str
    title: str

    @property
    def chooses_times(self) -> bool:
        """The critic chooses among schedules."""
        return True

    @property
    def hyper_parameters(self) -> type:
        """The type of its presets."""
        return Algorithm

    def preset(self, mode: str, robot: Robot) -> Algorithm:
        """Hyper-parameters in a mode for a robot."""
        return make_algorithm(mode, self.name, robot)

    def learner(self, task: Task, algorithm: Algorithm, epoch: int = 1) -> TgpoLearner:
        """A learner, from an epoch on."""
        return TgpoLearner(task, algorithm, epoch)

    def controller(self, algorithm: Algorithm, weights: Parameters) -> TgpoController:
        """The controller of given weights."""
        return TgpoController(algorithm, weights)


TGPO = Tgpo("tgpo", "TGPO (uniform schedules)")
TGPO_STAR = Tgpo("tgpo-star", "TGPO* (critic-guided schedules)")


def _sources(state: LearnerState) -> Sources:
    return Sources(state.parameters, state.chains, state.elite)
