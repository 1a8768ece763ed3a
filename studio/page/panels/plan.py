"""What the robot's weights have to say of the scene, and the plans of other kinds to choose."""

from core.decompose import Kind
from studio.page.panels.exact import shown_html
from studio.page.panels.html import note
from studio.page.session import Session
from studio.runs.recording import Recording


def plan_html(session: Session) -> str:
    """A sentence on the plan that is shown without training; empty where there is none."""
    other = moved_html(session) or shown_html(session)
    if other:
        return other
    planned, found = session.planner.training, session.analyst.answer
    if planned is None or session.subject is not planned:
        return ""
    if found is None or found.subject.training is not planned.identity:
        if session.analyst.error:
            return ""
        waiting = "Planning…" if found is not None else "Preparing the first plan…"
        return f'<div class="tg tg-plan tg-dim">{waiting}</div>'
    if found.seconds is None:
        return ""
    recording = found.recordings[0]
    if not recording.satisfied:
        lack = f"misses by {-recording.robustness:.2f} m"
        return note(f"No plan found without training: the best attempt {lack}. Train.", "warn")
    told = f"Planned without training in {found.seconds:.2f} s"
    if recording.nudged:
        told += ", nudged for this start"
    return f'<div class="tg tg-plan">{told}{_share(session, recording.nudged)}</div>'


def moved_html(session: Session) -> str:
    """A sentence on a rollout whose robot was moved; empty for every other one."""
    held, found, shown = session.hand.held, session.analyst.answer, session.player.recording
    if held is not None:
        doing = "Planning anew…" if held.released else f"Moved at step {held.step}…"
        return f'<div class="tg tg-plan tg-dim">{doing}</div>'
    if found is None or found.moved is None or shown is None or shown is not found.recordings[0]:
        return ""
    step, falsified, seconds = found.moved
    why = shown.diagnosis.sentence.removeprefix("Violated: ")
    if falsified is not None:
        text = f"Moved at step {step}. Nothing can satisfy the formula any more: {why}"
        return note(text, "warn")
    if not shown.satisfied:
        text = f"Moved at step {step}; no continuation was found in {seconds:.2f} s: {why}"
        return note(text, "warn")
    how = ", by nudging actions" if shown.nudged else ""
    return (
        f'<div class="tg tg-plan">Moved at step {step}; planned anew in {seconds:.2f} s{how}: '
        "satisfied.</div>"
    )


def alternatives(session: Session) -> tuple[tuple[str, Recording], ...]:
    """Name and rollout of the plan and of each other kind of plan; empty where there is one."""
    found = session.analyst.answer
    if found is None or not found.alternatives:
        return ()
    plans = (found.recordings[0], *found.alternatives)
    return tuple((order_text(plan), plan) for plan in plans)


def order_text(recording: Recording) -> str:
    """The goals in the order in which their windows begin: `A2 → A1`."""
    goals = [outcome for outcome in recording.outcomes if outcome.kind is not Kind.INVARIANT]
    goals.sort(key=lambda outcome: outcome.start)
    names = [goal.predicate for goal in goals if goal.end >= goal.start]
    return " → ".join(dict.fromkeys(names)) or "plan"


def _share(session: Session, nudged: bool) -> str:
    share, found = session.analyst.share, session.analyst.answer
    if share is None or found is None or share.subject is not found.subject:
        return "."
    succeeded = f"{share.succeeded} of {share.starts} starts succeed"
    return f"; without nudges {succeeded}." if nudged else f"; {succeeded}."
