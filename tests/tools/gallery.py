"""A gallery of the shipped scenes: docs/gallery.md and a sheet of pictures for each robot.

    python -m tests.tools.gallery [FOLDER]

Planar scenes are seen from above. Scenes in space are seen obliquely, in parallel projection;
thin lines lead from what floats down to its footprint, and the walls around the workspace are
left out. Colours are the page's.
"""

import io
import math
import sys
from importlib import resources
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, Polygon, Rectangle
from matplotlib.patheffects import AbstractPathEffect, withStroke
from PIL import Image
from scipy.spatial import ConvexHull

from envs import ENVS
from scenes import Region, Scene, parse_scene
from studio.page.views.outlines import outline
from studio.page.views.regions import DEFAULT_COLOR, START, Look, initial_look, region_look
from studio.page.views.roles import Role, roles
from studio.runs.tasks import decompose_scene

FOLDER = Path(__file__).parents[2] / "docs"
COLUMNS, WIDTH, DPI = 4, 3.0, 100
GROUND, LINE, INK = "#f7f8fa", "#ced4da", "#343a40"
ELEVATION, TURN = math.radians(32), math.radians(28)
IN_SPACE = 0.6
"""Opacity of solids in space."""
SMALL = 0.03
"""Planar regions smaller than this share of the workspace have their names below them."""
ROLE_NAMES = {Role.GOAL: "goal", Role.OBSTACLE: "obstacle", Role.DOOR: "door"}


def main(folder: Path) -> None:
    """Write the text and the sheets."""
    (folder / "images").mkdir(parents=True, exist_ok=True)
    (folder / "gallery.md").write_text(text(), encoding="utf-8")
    for robot in ENVS:
        path = folder / "images" / f"gallery-{robot}.png"
        sheet = io.BytesIO()
        draw_sheet(shipped(robot)).savefig(sheet, dpi=DPI)
        Image.open(sheet).convert("RGB").save(path, optimize=True)
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def shipped(robot: str) -> list[Scene]:
    """Every scene that comes with a robot: its tasks, then what else there is."""
    files = resources.files("scenes").joinpath(robot).iterdir()
    names = sorted(file.name for file in files if file.name.endswith(".toml"))
    folder = resources.files("scenes").joinpath(robot)
    return [parse_scene(folder.joinpath(n).read_text("utf-8"), f"{robot}/{n}") for n in names]


def text() -> str:
    """The page: for each robot its sheet, and title and formula of each scene."""
    lines = [
        "# Gallery",
        "",
        "All shipped scenes, drawn by `make gallery`: goals blue (keys green), obstacles grey,",
        "doors red, the initial set yellow. The numbered formulas are the paper's (App. A.8);",
        "the coordinates are ours. In 3D scenes the walls of the workspace are omitted, and thin",
        "lines lead to the ground.",
    ]
    for robot in ENVS:
        lines += ["", f"## {robot.capitalize()}", "", f"![Scenes](images/gallery-{robot}.png)", ""]
        lines += ["| scene | what | formula |", "|---|---|---|"]
        for scene in shipped(robot):
            formula = " ".join(scene.formula.split()).replace("|", "\\|")
            lines.append(f"| `{scene.name}` | {scene.title} | `{formula}` |")
    return "\n".join(lines) + "\n"


def draw_sheet(scenes: list[Scene]) -> Figure:
    """Pictures of scenes of one robot, with a legend."""
    rows = math.ceil(len(scenes) / COLUMNS)
    figure = Figure(layout="constrained")
    for place in figure.subplots(rows, COLUMNS, squeeze=False).flat:
        place.set_axis_off()
    for scene, axes in zip(scenes, figure.axes, strict=False):
        (draw_plan if scene.dimension == 2 else draw_oblique)(axes, scene)
        axes.set_title(scene.name, fontsize=10, color=INK)
        axes.set_aspect("equal")
    height = WIDTH * float(np.ptp(figure.axes[0].get_ylim()) / np.ptp(figure.axes[0].get_xlim()))
    figure.set_size_inches(COLUMNS * WIDTH, rows * (height + 0.27) + 0.35)
    colors = {name: DEFAULT_COLOR[role] for role, name in ROLE_NAMES.items()} | {"start": START}
    keys = [Patch(facecolor=color, edgecolor=INK, label=name) for name, color in colors.items()]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys), frameon=False)
    return figure


def draw_plan(axes: Axes, scene: Scene) -> None:
    """A planar scene from above."""
    (left, right), (front, back) = ENVS[scene.robot].workspace.arena
    axes.set_xlim(left - 0.2, right + 0.2)
    axes.set_ylim(front - 0.2, back + 0.2)
    axes.add_patch(Rectangle((left, front), right - left, back - front, fc=GROUND, ec=LINE))
    for region, look in looks(scene):
        x, y = region.center
        width, depth = np.resize(region.size, 2)
        style = {"fc": look.color, "ec": INK, "lw": 0.7, "alpha": max(look.opacity, IN_SPACE)}
        if region.kind == "circle":
            axes.add_patch(Circle((x, y), width, **style))
        else:
            axes.add_patch(Rectangle((x - width, y - depth), 2 * width, 2 * depth, **style))
        small = SMALL * (right - left)
        below = depth + small if max(width, depth) < small else 0.0
        _write(axes, x, y - below, look.label)


def draw_oblique(axes: Axes, scene: Scene) -> None:
    """A scene in space, from the front and above; what is behind is drawn first."""
    limits = np.array(ENVS[scene.robot].workspace.arena)
    center, half = limits.mean(1), np.diff(limits)[:, 0] / 2
    view = _view(wide=half[0] >= half[1])
    room = outline(Region("room", "box", tuple(center), tuple(half)), 0.0)
    ground = room.reshape(-1, 3)[np.isclose(room.reshape(-1, 3)[:, 2], limits[2, 0])]
    axes.add_patch(_hull(view, ground, fc=GROUND, ec="none"))
    axes.add_collection(LineCollection(list((room @ view.T)[..., :2]), colors=LINE, linewidths=0.7))
    shown = [(r, look) for r, look in looks(scene) if not _outside(r, limits)]
    shown.sort(key=lambda pair: -float(view[2] @ pair[0].center))
    for region, _ in shown:
        _draw_footprint(axes, view, region, limits[2, 0])
    for region, look in shown:
        _draw_solid(axes, view, region, look.color)
    _write_apart(axes, view, shown, gap=0.035 * float(half.max()) * 2)
    axes.autoscale_view()


def looks(scene: Scene) -> list[tuple[Region, Look]]:
    """The initial set and the regions with their looks on the page, obstacles first."""
    found = roles(scene.region_names, decompose_scene(scene))
    regions = sorted(scene.regions, key=lambda region: found[region.name] is not Role.OBSTACLE)
    shown = [(region, region_look(region, found[region.name])) for region in regions]
    return [*shown, (scene.initial, initial_look(scene.initial))]


def _view(wide: bool) -> np.ndarray:
    """Rows: right, up and away, as seen from the broad side of the workspace."""
    turn = TURN if wide else math.pi / 2 - TURN
    away = np.array([-math.sin(turn), math.cos(turn), 0.0])
    right = np.array([math.cos(turn), math.sin(turn), 0.0])
    upright = np.array([0.0, 0.0, 1.0])
    up = math.sin(ELEVATION) * away + math.cos(ELEVATION) * upright
    return np.stack([right, up, math.cos(ELEVATION) * away - math.sin(ELEVATION) * upright])


def _outside(region: Region, limits: np.ndarray) -> bool:
    """Whether a region is a wall of the workspace: centred beyond its limits."""
    center = np.array(region.center)
    return bool(((center < limits[:, 0]) | (center > limits[:, 1])).any())


def _draw_footprint(axes: Axes, view: np.ndarray, region: Region, ground: float) -> None:
    points = outline(region, 0.0).reshape(-1, 3).copy()
    bottom = points[:, 2].min()
    if bottom <= ground + 1e-9:
        return
    points[:, 2] = ground
    axes.add_patch(_hull(view, points, fc="#00000014", ec=LINE, lw=0.6))
    x, y, _ = region.center
    way = (np.array([[x, y, bottom], [x, y, ground]]) @ view.T)[:, :2]
    axes.plot(*way.T, color="#969ea8", lw=0.8)


def _draw_solid(axes: Axes, view: np.ndarray, region: Region, color: str) -> None:
    edges = outline(region, 0.0)
    points = edges.reshape(-1, 3)
    style = {"fc": color, "ec": INK, "lw": 0.7, "alpha": IN_SPACE}
    if region.kind == "sphere":
        right, up, _ = view @ region.center
        axes.add_patch(Circle((right, up), region.size[0], **style))
        return
    axes.add_patch(_hull(view, points, **style))
    cap = points[np.isclose(points[:, 2], points[:, 2].max())]
    axes.add_patch(_hull(view, cap, fc="#ffffff55", ec=INK, lw=0.5))


def _hull(view: np.ndarray, points: np.ndarray, **style) -> Polygon:
    """The silhouette of points [n, 3]."""
    flat = (points @ view.T)[:, :2]
    return Polygon(flat[ConvexHull(flat).vertices], **style)


def _write_apart(
    axes: Axes, view: np.ndarray, shown: list[tuple[Region, Look]], gap: float
) -> None:
    """Labels at the centres, raised where they would cover one another."""
    taken: list[np.ndarray] = []
    for region, look in shown:
        place = (view @ region.center)[:2]
        while any((np.abs(place - other) < (1.5 * gap, gap)).all() for other in taken):
            place = place + (0.0, gap)
        taken.append(place)
        _write(axes, place[0], place[1], look.label)


def _write(axes: Axes, x: float, y: float, label: str) -> None:
    halo: list[AbstractPathEffect] = [withStroke(linewidth=2.2, foreground="white")]
    text = axes.text(x, y, label, ha="center", va="center", fontsize=8, color=INK)
    text.set_path_effects(halo)
    text.set_parse_math(False)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
