"""The scene: floor, regions by their roles, and the initial set."""

import viser

from envs import ENVS
from scenes import Region, Scene
from studio.session import Session
from studio.views.roles import Role, roles
from studio.views.solids import add_solid, rgb

FLOOR, GRID, START = (247, 248, 250), (226, 229, 234), "#f6bd60"
DEFAULT_COLOR = {
    Role.GOAL: "#8ecae6",
    Role.OBSTACLE: "#6b7178",
    Role.DOOR: "#f4978e",
    Role.UNUSED: "#c9ced6",
}
HEIGHT = {Role.GOAL: 0.03, Role.OBSTACLE: 0.55, Role.DOOR: 0.3, Role.UNUSED: 0.015}
"""Of planar regions [m]."""
OPACITY = {Role.GOAL: 0.85, Role.OBSTACLE: 1.0, Role.DOOR: 0.6, Role.UNUSED: 0.5}


class RegionsView:
    """Rebuilt when the scene or the roles of its regions change."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._server = server
        self._drawn: tuple[Scene, dict[str, Role]] | None = None
        server.initial_camera.position = (0.0, -13.0, 15.8)
        server.initial_camera.look_at = (0.0, -1.9, 0.0)
        server.initial_camera.fov = 0.8
        _light(self._scene)

    def draw(self, session: Session) -> None:
        """Show the scene under the formula that was right last."""
        specification = session.specification
        scene, decomposition = specification.scene, specification.decomposition
        current = (scene, roles(scene.region_names, decomposition))
        if current == self._drawn:
            return
        self._drawn = current
        with self._server.atomic():
            self._scene.remove_by_name("/scene")
            self._draw_floor(scene)
            for index, region in enumerate(scene.regions):
                self._draw_region(f"/scene/region{index}", region, current[1][region.name])
            self._draw_initial(scene.initial)

    def _draw_floor(self, scene: Scene) -> None:
        (left, right), (front, back) = ENVS[scene.robot].workspace[:2]
        width, depth = right - left, back - front
        middle = ((left + right) / 2, (front + back) / 2)
        self._scene.add_box(
            "/scene/floor",
            FLOOR,
            (width, depth, 0.1),
            position=(*middle, -0.051),
            cast_shadow=False,
        )
        self._scene.add_grid(
            "/scene/grid",
            width,
            depth,
            cell_size=1.0,
            section_size=5.0,
            cell_color=GRID,
            section_color=GRID,
            shadow_opacity=0.0,
            position=(*middle, 0.002),
        )

    def _draw_region(self, name: str, region: Region, role: Role) -> None:
        chosen = None if role is Role.UNUSED else region.color
        top = add_solid(
            self._scene,
            name,
            region,
            rgb(chosen or DEFAULT_COLOR[role]),
            HEIGHT[role],
            OPACITY[role],
        )
        self._label(name, region.name, (0.0, 0.0, top), 0.9)

    def _draw_initial(self, region: Region) -> None:
        top = add_solid(
            self._scene, "/scene/initial", region, rgb(region.color or START), 0.02, 0.75
        )
        front = -region.size[min(1, len(region.size) - 1)]
        self._label("/scene/initial", "start", (0.0, front, top), 0.8)

    def _label(
        self, name: str, label: str, position: tuple[float, float, float], scale: float
    ) -> None:
        self._scene.add_label(
            f"{name}/label",
            label,
            position=position,
            anchor="center-center",
            font_screen_scale=scale,
        )


def _light(scene: viser.SceneApi) -> None:
    """Lights under which colours look as they are given; the default ones bleach the floor."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/lights/ambient", intensity=1.9)
    scene.add_light_directional(
        "/lights/sun", intensity=1.7, position=(-4.0, -5.0, 10.0), cast_shadow=True
    )
