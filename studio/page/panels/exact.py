"""What a search for an exact plan has found so far, or has proved."""

import math
import time

from studio.page.editing.meaning import differences
from studio.page.exact import Search
from studio.page.panels.html import note
from studio.page.session import Session


def exact_html(session: Session) -> str:
    """A sentence and numbers on the latest search; empty where there is none."""
    search = session.exact.search
    if search is None:
        return ""
    if search.error:
        return note(f"No exact plan: {search.error}")
    if search.running:
        return progress_html(search, time.monotonic() - search.began)
    stale = differences(search.scene, session.document.scene)
    about = f" This was before {stale[0]} changed." if stale else ""
    return note(verdict_text(search) + about, "warn" if stale else "info")


def progress_html(search: Search, seconds: float) -> str:
    """The time that a search has taken, the best trace and the bound that it knows.

    Args:
        search: that runs.
        seconds: since it began.
    """
    best, bound = search.watch.robustness, search.watch.bound
    stopping = search.watch.stop.is_set()
    numbers = (
        (_metres(best), "best so far"),
        (_metres(bound), "proved bound"),
        (_metres(bound - max(best, 0.0) if math.isfinite(best) else math.nan), "gap"),
    )
    cards = "".join(
        f'<div class="tg-card"><b>{value}</b><span>{name}</span></div>' for value, name in numbers
    )
    doing = "Stopping…" if stopping else "Searching for the most robust plan:"
    doing += f" {seconds:.0f} of {search.limit:.0f} s"
    return (
        f'<div class="tg tg-exact"><div>{doing}</div>'
        f'<div class="tg-cards" style="margin-top:0.4em">{cards}</div></div>'
    )


def verdict_text(search: Search) -> str:
    """What a search that has ended says."""
    plan, stopped = search.plan, search.watch.stop.is_set()
    assert plan is not None
    end = "Stopped" if stopped else f"The time limit of {search.limit:.0f} s was reached"
    reached, carried = plan.robustness, search.recording
    bound = "" if not math.isfinite(plan.bound) else f"; proved bound {plan.bound:.2f} m"
    remark = ""
    if carried is not None and not carried.satisfied:  # as between the steps
        remark = f" Carried out: {carried.diagnosis.sentence}"
    match plan.status:
        case "optimal":
            values = f"robustness {reached:.2f} m, proved bound {plan.bound:.2f} m"
            return f"Optimal: {values} ({plan.seconds:.1f} s).{remark}"
        case "infeasible":
            return (
                "Infeasible, proved: nothing from this start satisfies the formula "
                f"({plan.seconds:.1f} s)."
            )
        case "feasible":
            return f"{end}. Best plan so far: robustness {reached:.2f} m{bound}.{remark}"
        case _:
            return f"{end} before a plan was found or excluded{bound}."


def shown_html(session: Session) -> str:
    """A sentence over the rollout where it is the exact plan; empty where it is another."""
    search = session.exact.search
    if search is None or search.recording is None:
        return ""
    if session.player.recording is not search.recording:
        return ""
    return '<div class="tg tg-plan">The exact plan, carried out by the robot.</div>'


def _metres(value: float) -> str:
    return f"{value:.2f} m" if math.isfinite(value) else "–"
