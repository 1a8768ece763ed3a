"""Progress of a training: a sentence and a few numbers."""

import math
import time

from core.methods import METHODS
from core.methods.training import TrainingConfig
from studio.page.figures.svg import escape
from studio.page.session import Session
from studio.page.settings import EXACT, FOREVER
from studio.page.trainer import Phase, Training


def share_done(training: Training) -> float:
    """Share of the budget used, 1 once training has ended."""
    config = training.config
    if config is None or training.phase is Phase.COMPILING:
        return 0.0
    if training.phase is Phase.DONE:
        return 1.0
    epochs = max(1, config.epochs - training.began_epoch)
    seconds = max(1e-6, config.time_limit - training.began_seconds)
    by_epochs = (training.epoch - training.began_epoch) / epochs
    return min(1.0, max(by_epochs, (training.seconds - training.began_seconds) / seconds))


def epoch_rate(training: Training) -> float | None:
    """Epochs a second since the training was started or resumed; None before the first."""
    seconds = training.seconds - training.began_seconds
    epochs = training.epoch - training.began_epoch
    return epochs / seconds if seconds > 0 and epochs > 0 else None


def eta(training: Training) -> float | None:
    """Seconds until the budget is used up at the latest; None where that is not known yet.

    Nothing is known while epochs of another pace are still to come (see `Learner.pace_change`).
    """
    config, rate = training.config, epoch_rate(training)
    if config is None or rate is None:
        return None
    change = training.pace_change
    if change is not None and change < config.epochs:
        since = next((p for p in training.curve if p.epoch == change), None)
        epochs = training.epoch - change
        if epochs > 0 and since is not None:
            rate = epochs / max(training.seconds - since.seconds, 1e-6)
        elif training.began_epoch < change:
            return None
    left = config.time_limit - training.seconds
    return max(0.0, min(left, (config.epochs - training.epoch) / rate))


def status_html(session: Session) -> str:
    """The sentence and the cards."""
    training = session.training
    sentence = _sentence(session)
    cards = "".join(
        f'<div class="tg-card"><b>{value}</b><span>{name}</span></div>'
        for value, name in _numbers(training)
    )
    if cards:
        cards = f'<div class="tg-cards" style="margin-top:0.4em">{cards}</div>'
    broken = _broken_down(training)
    return f'<div class="tg tg-training"><div>{sentence}</div>{cards}{broken}</div>'


def _broken_down(training: Training) -> str:
    """How many simulations have diverged so far, if any."""
    count = sum(point.diverged for point in training.curve)
    if not count:
        return ""
    what = "simulation" if count == 1 else "simulations"
    return f'<div class="tg-note tg-warn">{count:,} {what} diverged and counted as failed.</div>'


def _numbers(training: Training) -> list[tuple[str, str]]:
    if not training.curve or not training.epoch:
        return []
    success, last = training.success, training.curve[-1]
    shown = last.batch_success if success is None else success
    numbers = [(f"{100 * shown:.1f} %", "success"), (f"{training.epoch}", "epochs")]
    rate = epoch_rate(training)
    if rate is None:
        return numbers
    steps = training.env_steps / max(training.epoch, 1) * rate
    return [
        *numbers,
        (f"{training.seconds:.1f} s", "training"),
        (f"{last.batch_return:+.2f}", "return / step"),
        (f"{rate:.1f}", "epochs / s"),
        (f"{steps / 1000:.0f} k", "steps / s"),
    ]


def _sentence(session: Session) -> str:
    training = session.training
    config = training.config
    match training.phase:
        case Phase.IDLE:
            return f'<span class="tg-dim">{_invitation(session)}</span>'
        case Phase.LOADED:
            return _loaded(session)
        case Phase.COMPILING:
            waited = time.monotonic() - training.began
            return f"Compiling… {waited:.0f} s (once per robot)"
        case Phase.TRAINING if config is not None:
            return f"Training… {_remaining(training, config)}{_goal(config)}"
        case Phase.PAUSED:
            return "Paused. Resume continues exactly where training paused."
        case Phase.STOPPED:
            return "Stopped. The best policy so far is kept."
        case Phase.FAILED:
            return "Training failed."
        case _:
            reached = config is not None and (training.success or 0) >= config.target
            longer = config is not None and config.target > 1
            return "Done." if reached or longer else "Done: limit reached before the target."


def _invitation(session: Session) -> str:
    if session.exactly:
        return "Finds the most robust plan from the start and proves how robust any can be."
    if session.settings.method != EXACT and not METHODS[session.settings.method].chooses_times:
        return "Trains a policy for the formula as a whole, from scratch."
    if session.planner.training is None or not session.settings.from_weights:
        return "Trains a policy and a critic for the formula, usually in 10–40 s."
    return "Trains the robot's weights further for this formula, usually in seconds."


def _loaded(session: Session) -> str:
    origin = escape(session.training.origin)
    if session.analyst.picture is None and not session.analyst.error:
        return f"Showing {origin}. Warming up…"
    return f"Showing {origin}. Train starts from scratch."


def _remaining(training: Training, config: TrainingConfig) -> str:
    left = eta(training)
    if left is not None and math.isfinite(left) and config.epochs <= FOREVER:
        return f"at most {left:.0f} s left"
    return f"at most {config.epochs - training.epoch:,} epochs left"


def _goal(config: TrainingConfig) -> str:
    return f"; stops at {100 * config.target:g} % success" if config.target <= 1 else ""
