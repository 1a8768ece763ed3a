"""True meshes from a stand-in for the menagerie's cache: the model's names, tiny meshes."""

import numpy as np
import pytest

from studio.page.views.bodies import menagerie
from studio.page.views.bodies.arm_pieces import arm_pieces

TETRAHEDRON = """
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def _body(name, inner, joint="hinge", position="0 0 0.1"):
    axis = f'<joint type="{joint}" axis="0 0 1"/>' if joint else ""
    return (
        f'<body name="{name}" pos="{position}">{axis}'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        '<geom type="mesh" mesh="shell" contype="0" conaffinity="0" rgba="0.2 0.4 0.6 1"/>'
        f'<geom type="mesh" mesh="shell"/>{inner}</body>'
    )


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """A checkout with the arm alone, found as the package finds one."""
    fingers = _body("left_finger", "", "slide", "0 0 0.05") + _body(
        "right_finger", "", "slide", "0 0 0.05"
    )
    chain = _body("hand", fingers, "", "0 0 0.107")
    for joint in range(7, 0, -1):
        chain = _body(f"link{joint}", chain)
    chain = _body("link0", chain, "", "0 0 0")
    folder = tmp_path / menagerie.ROBOT
    folder.mkdir()
    (folder / "shell.obj").write_text(TETRAHEDRON)
    (folder / "panda.xml").write_text(
        f'<mujoco><asset><mesh name="shell" file="shell.obj"/></asset>'
        f"<worldbody>{chain}</worldbody></mujoco>"
    )
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    menagerie.menagerie_pieces.cache_clear()
    yield folder
    menagerie.menagerie_pieces.cache_clear()


def test_the_links_take_their_visible_meshes(stand_in):
    pieces = menagerie.menagerie_pieces()
    assert pieces is not None
    assert set(pieces) == set(arm_pieces())
    assert {name: len(found) for name, found in pieces.items()} == (
        dict.fromkeys(pieces, 1) | {"hand": 3}
    )
    for mesh, color in pieces["link3"]:
        assert color == (51, 102, 153)
        np.testing.assert_allclose(mesh.bounds, [[0, 0, 0], [0.1, 0.1, 0.1]], atol=1e-6)
    palm, finger, _ = (piece.mesh.bounds[0, 2] for piece in pieces["hand"])
    assert palm == pytest.approx(0.107, abs=1e-6)
    assert finger == pytest.approx(0.107 + 0.05 + menagerie.OPENING, abs=1e-6)


def test_an_unreadable_model_leaves_the_drawn_shells(stand_in):
    (stand_in / "panda.xml").write_text("<mujoco>")
    assert menagerie.menagerie_pieces() is None


def test_without_a_cache_nothing_is_downloaded(tmp_path, monkeypatch):
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path))
    menagerie.menagerie_pieces.cache_clear()
    assert menagerie.menagerie_pieces() is None
    assert list(tmp_path.iterdir()) == []
