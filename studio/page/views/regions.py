"""The regions by their roles, and the initial set; a click selects one, a drag moves it.

Regions that move are where they are at the playhead; without a rollout, where they begin.
"""

from functools import partial
from typing import NamedTuple

import viser

from scenes import Region, Scene, unit_of
from scenes.starts import inner_point
from studio.page.editing.editor import CLICKED, SELECT, Phase, Point
from studio.page.editing.selection import INITIAL
from studio.page.session import Session
from studio.page.views.floor import click_corner, drawing_drag
from studio.page.views.pointer import on_level_drag, ray_of
from studio.page.views.roles import Role, roles
from studio.page.views.solids import Solid, add_solid, body_position, place_solid, rgb, seen, top
from studio.page.views.walls import Face, add_face, wall_faces

START = "#f6bd60"
DEFAULT_COLOR = {
    Role.GOAL: "#8ecae6",
    Role.OBSTACLE: "#6b7178",
    Role.DOOR: "#f4978e",
    Role.UNUSED: "#c9ced6",
}
HEIGHT = {Role.GOAL: 0.03, Role.OBSTACLE: 0.55, Role.DOOR: 0.3, Role.UNUSED: 0.015}
"""Of planar regions [m]."""
OPACITY = {Role.GOAL: 0.85, Role.OBSTACLE: 1.0, Role.DOOR: 0.6, Role.UNUSED: 0.5}
OPACITY_IN_SPACE = {Role.GOAL: 0.5, Role.OBSTACLE: 0.8, Role.DOOR: 0.4, Role.UNUSED: 0.25}
START_HEIGHT, START_OPACITY, START_OPACITY_IN_SPACE = 0.02, 0.75, 0.4


class Look(NamedTuple):
    """The properties whose change rebuilds a body; position and size are only updated."""

    label: str
    kind: str
    color: str
    height: float
    opacity: float
    face: Face | None = None
    """Set for a wall of the workspace, of which nothing else is drawn."""


class Shown(NamedTuple):
    """A body on screen."""

    look: Look
    region: Region
    body: Solid
    label: viser.LabelHandle | None


class RegionsView:
    """Node `/scene/region0`, ... in the scene's order, and `/scene/initial`."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._server = server
        self._shown: dict[str, Shown] = {}
        self._drawn: tuple | None = None
        self._step = 0.0
        _light(self._scene)

    def draw(self, session: Session) -> None:
        """Show the edited scene, with roles from the last valid formula."""
        scene, decomposition = session.document.scene, session.specification.decomposition
        step = shown_step(session)
        current = (session.document, scene, decomposition)
        if self._drawn is not None and all(a is b for a, b in zip(current, self._drawn)):  # noqa: B905
            self._displace(scene, step)
            return
        self._drawn, self._step = current, step
        found = roles(scene.region_names, decomposition)
        faces = wall_faces(scene)
        wanted = {
            f"/scene/region{index}": (
                region_look(region, found[region.name])._replace(face=faces.get(region.name)),
                region.displaced(step),
            )
            for index, region in enumerate(scene.regions)
        }
        initial = seen(scene.initial, unit_of(scene))
        wanted["/scene/initial"] = (initial_look(initial), initial)
        with self._server.atomic():
            for node in [node for node in self._shown if node not in wanted]:
                self._shown.pop(node).body.remove()
            for node, (look, region) in wanted.items():
                self._show(session, node, look, region)

    def _displace(self, scene: Scene, step: float) -> None:
        """Only move what moves: the shapes stay as they are."""
        if step == self._step:
            return
        self._step = step
        with self._server.atomic():
            for index, region in enumerate(scene.regions):
                node = f"/scene/region{index}"
                shown = self._shown[node]
                if region.motion is not None and shown.look.face is None:
                    there = region.displaced(step)
                    shown.body.position = body_position(there, shown.look.height)
                    self._shown[node] = shown._replace(region=there)

    def _show(self, session: Session, node: str, look: Look, region: Region) -> None:
        shown = self._shown.get(node)
        if shown is not None and shown.look == look:
            if shown.region != region:
                if look.face is None:
                    place_solid(shown.body, region, look.height)
                if shown.label is not None:
                    shown.label.position = _label_position(node, region, look.height)
                self._shown[node] = shown._replace(region=region)
            return
        if shown is not None:
            shown.body.remove()
        if look.face is not None:
            wall = add_face(self._scene, node, look.face)
            self._shown[node] = Shown(look, region, wall, None)
            return
        body = add_solid(self._scene, node, region, rgb(look.color), look.height, look.opacity)
        label = self._scene.add_label(
            f"{node}/label",
            look.label,
            position=_label_position(node, region, look.height),
            anchor="center-center",
            font_screen_scale=0.8 if node.endswith("initial") else 0.9,
        )
        self._shown[node] = Shown(look, region, body, label)
        _listen(session, body, INITIAL if node.endswith("initial") else region.name)


def shown_step(session: Session) -> float:
    """The step at which regions are shown: that of the playhead, or the first.

    Always the first where nothing moves.
    """
    player = session.player
    still = player.recording is None or not session.document.scene.moving
    return 0.0 if still else float(player.position)


def region_look(region: Region, role: Role) -> Look:
    """How a region is drawn in a role."""
    chosen = None if role is Role.UNUSED else region.color
    color = chosen or DEFAULT_COLOR[role]
    opacity = (OPACITY if region.dimension == 2 else OPACITY_IN_SPACE)[role]
    return Look(region.name, region.kind, color, HEIGHT[role], opacity)


def initial_look(region: Region) -> Look:
    """How the initial set is drawn."""
    opacity = START_OPACITY if region.dimension == 2 else START_OPACITY_IN_SPACE
    return Look("start", region.kind, region.color or START, START_HEIGHT, opacity)


def _listen(session: Session, body: Solid, target: str) -> None:
    """A click selects, a drag moves; while a drawing tool is active, a drag draws."""
    draw = drawing_drag(session)

    def move(phase: Phase, start: Point, end: Point) -> None:
        if session.editor.tool == SELECT:
            session.post(lambda: session.editor.move(target, phase, start, end))

    def draw_with_tool(phase: Phase, start: Point, end: Point) -> None:
        if session.editor.tool != SELECT:
            draw(phase, start, end)

    on_level_drag(body, move)
    on_level_drag(body, draw_with_tool, height=0.0)
    on_level_drag(body, draw, height=0.0, modifier="shift")
    if target != INITIAL:

        @body.on_click
        async def _(event: viser.SceneNodePointerEvent) -> None:
            if session.editor.tool in CLICKED:
                click_corner(session, event)
            else:
                session.post(partial(session.editor.click, target, ray_of(event)))


def _label_position(node: str, region: Region, height: float) -> tuple[float, float, float]:
    planar = node.endswith("initial") and region.dimension == 2
    if planar:
        return 0.0, -float(region.half_extents[1]), top(region, height)
    x, y, *_ = inner_point(region) - region.center
    return float(x), float(y), top(region, height)


def _light(scene: viser.SceneApi) -> None:
    """Lights that keep colours as given; the default ones wash out the floor."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/lights/ambient", intensity=1.9)
    scene.add_light_directional(
        "/lights/sun", intensity=1.7, position=(-4.0, -5.0, 10.0), cast_shadow=True
    )
