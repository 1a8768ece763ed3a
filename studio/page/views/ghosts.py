"""Rollouts beside the one that plays: a coloured path and a small body for each."""

import numpy as np
import viser

from studio.page.playing.gallery import Gallery, Ghost
from studio.page.session import Session
from studio.page.views.robot import between, lifted, segments
from studio.page.views.solids import rgb
from studio.runs.recording import Recording
from studio.theme import BAD, GOOD

LIFT, SAMPLE_LIFT, THICKNESS, SAMPLE_THICKNESS, RADIUS = 0.045, 0.02, 0.05, 0.03, 0.13
"""In robot lengths."""


class GhostsView:
    """Nodes `/ghosts/0`, ... and `/sample/0`, ...; ghosts are drawn at the playhead."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._ghosts: tuple[Ghost, ...] = ()
        self._sample: tuple[Recording, ...] = ()
        self._bodies: list[viser.IcosphereHandle] = []
        self._position: float | None = None

    def draw(self, session: Session) -> None:
        """Follow the gallery and the playhead."""
        gallery, position = session.gallery, session.player.position
        with self._server.atomic():
            if gallery.ghosts != self._ghosts:
                self._show_ghosts(gallery)
            if gallery.sample is not self._sample:
                self._show_sample(gallery.sample)
            if position != self._position:
                self._position = position
                for ghost, body in zip(self._ghosts, self._bodies, strict=True):
                    body.position = self._place(ghost, position)

    def _show_ghosts(self, gallery: Gallery) -> None:
        scene = self._server.scene
        scene.remove_by_name("/ghosts")
        self._ghosts, self._bodies, self._position = gallery.ghosts, [], None
        for index, ghost in enumerate(gallery.ghosts):
            name, color = f"/ghosts/{index}", rgb(ghost.color)
            robot = ghost.recording.task.robot
            path = segments(ghost.recording.positions, lifted(robot, LIFT))
            scene.add_line_segments(name, path, color, thickness=THICKNESS * robot.length)
            self._bodies.append(
                scene.add_icosphere(
                    f"{name}/body", RADIUS * robot.length, color, opacity=0.55, cast_shadow=False
                )
            )

    def _show_sample(self, sample: tuple[Recording, ...]) -> None:
        self._server.scene.remove_by_name("/sample")
        self._sample = sample
        for index, recording in enumerate(sample):
            color = rgb(GOOD if recording.satisfied else BAD)
            robot = recording.task.robot
            path = segments(recording.positions, lifted(robot, SAMPLE_LIFT))
            self._server.scene.add_line_segments(
                f"/sample/{index}", path, color, thickness=SAMPLE_THICKNESS * robot.length
            )

    def _place(self, ghost: Ghost, position: float) -> np.ndarray:
        recording = ghost.recording
        here = between(recording.positions, min(position, recording.steps))
        robot = recording.task.robot
        return here + np.array([0.0, 0.0, RADIUS * robot.length * (robot.position_size == 2)])
