"""Choosing where rollouts start: a click on the initial set."""

from functools import partial

import numpy as np
import viser

from core.errors import UserError
from scenes import Region, unit_of
from scenes.distances import margin_of
from scenes.starts import inner_point
from studio.page.session import Session
from studio.page.views.pointer import level_point
from studio.page.views.solids import add_solid, seen

PAD, HEIGHT, OPACITY = (255, 183, 3), 0.06, 0.55


class StartView:
    """A bright pad over the initial set while `Session.choosing_start`."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._drawn: Region | None = None

    def draw(self, session: Session) -> None:
        """Show or hide the pad."""
        region = session.specification.scene.initial if session.choosing_start else None
        if region == self._drawn:
            return
        self._drawn = region
        self._server.scene.remove_by_name("/start")
        if region is None:
            return
        shown = seen(region, unit_of(session.specification.scene))
        pad = add_solid(self._server.scene, "/start", shown, PAD, HEIGHT, OPACITY)

        @pad.on_click
        async def _(event: viser.SceneNodePointerEvent) -> None:
            if event.ray_origin is not None and event.ray_direction is not None:
                origin = np.asarray(event.ray_origin, float)
                direction = np.asarray(event.ray_direction, float)
                session.post(partial(start_at, session, region, origin, direction))


def start_at(session: Session, region: Region, origin: np.ndarray, direction: np.ndarray) -> None:
    """Start rollouts where a ray meets the initial set: a plan is made anew, a schedule repeated.

    Raises:
        UserError: the ray misses the initial set.
    """
    position = met(region, origin, direction)
    if region.kind == "point":
        position = region.center
    if margin_of(region, np.array([position]))[0] < -1e-3:
        raise UserError("Rollouts must start in the initial set: click in the highlighted area.")
    session.choosing_start = False
    session.analyst.choose_start(position)
    recording, found = session.player.recording, session.analyst.answer
    schedule = None if recording is None else recording.schedule_for(session.subject.task)
    if found is not None and (found.seconds is not None or found.moved is not None):
        session.analyst.ask()
    elif schedule is not None:
        session.analyst.ask(schedule)


def met(region: Region, origin: np.ndarray, direction: np.ndarray) -> tuple[float, ...]:
    """Where a ray meets the floor; in 3D, its nearest point to a region's middle."""
    if region.dimension == 2:
        return level_point(origin, origin + direction, 0.0)[:2]
    unit = direction / np.linalg.norm(direction)
    near = origin + unit * float(unit @ (inner_point(region) - origin))
    return tuple(float(value) for value in near)
