"""Where the parts of the robots are for known states; no browser, one server for the nodes."""

import io
import itertools
from contextlib import redirect_stdout
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree
from viser.transforms import SO3

from envs import ENVS, Ant, Panda, Quadrotor, make_robot
from envs.panda import FLANGE, READY
from envs.quadrotor import down_axis
from studio.page.server.security import start_server
from studio.page.views.bodies import Camera, body_of
from studio.page.views.bodies.arm_pieces import arm_pieces
from studio.page.views.bodies.ball import Ball
from studio.page.views.bodies.body import ROOT
from studio.page.views.bodies.spider import Spider
from tests.studio.conftest import free_port

BENT = np.array([0.7, 0.3, -0.5, -1.6, 0.4, 2.1, -0.8])


@pytest.fixture(scope="module")
def scene():
    with redirect_stdout(io.StringIO()):
        server = start_server("127.0.0.1", free_port(), "bodies")
        yield server.scene
        server.stop()


def _rest(robot, position):
    return np.array(ENVS[robot].rest(jax.random.key(1), jnp.asarray(position)))


def _axes(pose):
    return SO3(pose.wxyz).as_matrix()


@pytest.mark.parametrize("robot", ENVS)
def test_every_moving_part_is_posed(robot, scene):
    body, middle = body_of(ENVS[robot]), ENVS[robot].workspace.middle
    parts = body.build(scene, f"/{robot}")
    state = _rest(robot, middle)
    states = np.stack([state, state, state])
    track = body.track(states, np.zeros((2, ENVS[robot].action_size)))
    assert len(track) == 3
    assert (track[:, : len(state)] == states).all()
    for row in (state, track[-1]):
        poses = body.poses(row)
        assert set(poses) == {ROOT, *parts}
        for pose in poses.values():
            assert np.linalg.norm(pose.wxyz) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("robot", ["linear", "unicycle", "quadrotor"])
def test_the_root_is_where_the_robot_is(robot):
    state = _rest(robot, [1.0, -2.0, 3.0][: ENVS[robot].position_size])
    expected = np.zeros(3)
    expected[: ENVS[robot].position_size] = ENVS[robot].position(jnp.asarray(state))
    np.testing.assert_allclose(
        body_of(ENVS[robot]).poses(state)[ROOT].position, expected, atol=1e-6
    )


@pytest.mark.parametrize("size", [2, 3])
def test_a_robot_without_a_body_of_its_own_is_a_ball_where_it_is(scene, size):
    """Afloat in space, on its foot in the plane; the stage is its arena, seen whole."""
    robot = ENVS["quadrotor" if size == 3 else "unicycle"]
    arena = ((10.0, 12.0), (-3.0, 1.0), (0.0, 2.0))[:size]
    workspace = replace(robot.workspace, arena=arena, clearance=0.05)
    robot = replace(robot, drawn_as="submarine", workspace=workspace)  # pyright: ignore
    body = body_of(robot)
    assert isinstance(body, Ball)
    assert dict(body.build(scene, f"/ball{size}")) == {}
    names = {node for node in scene._handle_from_node_name if node.startswith(f"/ball{size}/")}
    assert names == {f"/ball{size}/ball"} | ({f"/ball{size}/foot"} if size == 2 else set())
    state = robot.rest(jax.random.key(0), jnp.array([11.0, -2.0, 1.5][:size]))
    found = body.poses(np.asarray(state))[ROOT].position
    np.testing.assert_allclose(found, [11.0, -2.0, 1.5 if size == 3 else 0.0], atol=1e-6)
    camera = body.stage.camera
    assert body.stage.floor == arena[:2]
    assert camera.look_at[0] == camera.position[0] == 11.0
    eye = np.array(camera.position)
    ahead = (np.array(camera.look_at) - eye) / np.linalg.norm(np.array(camera.look_at) - eye)
    across = np.array([1.0, 0.0, 0.0])
    above = np.cross(across, ahead)
    for x, y, z in itertools.product(*arena, *((0.0,) for _ in range(3 - size))):
        away = np.array([x, y, z]) - eye
        depth, half = away @ ahead, np.tan(camera.fov / 2)
        assert abs(away @ above) < half * depth
        assert abs(away @ across) < 1.5 * half * depth  # of a window 3 : 2


@pytest.mark.parametrize("robot", ["linear", "unicycle"])
def test_the_stage_of_the_planar_robots_is_what_it_was(robot):
    stage = body_of(ENVS[robot]).stage
    assert stage.floor == ((-5.0, 5.0), (-5.0, 5.0))
    assert stage.camera == Camera((0.0, -13.0, 15.8), (0.0, -1.9, 0.0))
    assert stage.cell == 1.0


def test_a_variant_has_a_body_of_its_own():
    """Under raw motors an action is the forces: idle rotors hover."""
    robot = make_robot("quadrotor", "raw-motors")
    states = np.stack([_rest("quadrotor", [0.0, 0.0, 2.0])] * 2)
    actions = np.array([[1.0, 0.0, 0.0, 0.0]], np.float32)
    turned = np.abs(body_of(robot).track(states, actions)[-1, robot.state_size :])
    assert turned[0] > 1.1 * turned[1]
    np.testing.assert_allclose(turned[1:], turned[1], rtol=1e-5)


def test_the_car_looks_along_its_heading():
    pose = body_of(ENVS["unicycle"]).poses(np.array([1.0, 2.0, np.pi / 2, 0.0]))[ROOT]
    np.testing.assert_allclose(_axes(pose)[:, 0], [0.0, 1.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("angles", [np.array(READY), BENT], ids=["ready", "bent"])
def test_the_hand_is_at_the_end_effector(angles):
    robot = Panda()
    poses = body_of(ENVS["panda"]).poses(angles)
    tip = np.asarray(robot.position(jnp.asarray(angles, jnp.float32)))
    reached = poses["hand"].position + _axes(poses["hand"])[:, 2] * (FLANGE + robot.tool)
    np.testing.assert_allclose(reached, tip, atol=1e-5)
    np.testing.assert_allclose(poses["tip"].position, tip, atol=1e-5)


@pytest.mark.parametrize("angles", [np.array(READY), BENT], ids=["ready", "bent"])
def test_the_links_of_the_arm_touch(angles):
    """Each shell reaches into the next one's, in any posture."""
    poses = body_of(ENVS["panda"]).poses(angles)
    names = ["base", *(f"link{i}" for i in range(1, 8)), "hand"]
    solids = {}
    for name in names:
        mesh = trimesh.util.concatenate([piece.mesh for piece in arm_pieces()[name]])
        pose = poses[name]
        surface = trimesh.sample.sample_surface(mesh, 3000, seed=0)[0]
        solids[name] = surface @ _axes(pose).T + pose.position
    for name, following in zip(names, names[1:], strict=False):
        gaps, _ = KDTree(solids[name]).query(solids[following])
        assert gaps.min() < 0.006, (name, following)


def test_the_arm_stands_on_the_table():
    lowest = min(piece.mesh.bounds[0, 2] for piece in arm_pieces()["base"])
    assert lowest == pytest.approx(0.0, abs=1e-6)
    (left, right), (front, back) = body_of(ENVS["panda"]).stage.floor
    for (low, high), (least, most) in zip(
        ENVS["panda"].workspace.arena[:2], ((left, right), (front, back)), strict=True
    ):
        assert least < low < high < most


def test_a_quadrotor_that_hovers_is_upright():
    state = _rest("quadrotor", [0.0, 0.0, 2.0])
    assert abs(state[8]) > 0.1  # heading
    axes = _axes(body_of(ENVS["quadrotor"]).poses(state)[ROOT])
    np.testing.assert_allclose(axes[:, 2], [0.0, 0.0, 1.0], atol=1e-6)
    ahead = [np.cos(state[8]), -np.sin(state[8]), 0.0]  # y of the paper points the other way
    np.testing.assert_allclose(axes[:, 0], ahead, atol=1e-6)


def test_the_quadrotor_leans_as_its_thrust_pulls():
    state = _rest("quadrotor", [0.0, 0.0, 2.0])
    state[6:9] = [0.3, -0.2, 0.7]
    axes = _axes(body_of(ENVS["quadrotor"]).poses(state)[ROOT])
    thrust = -np.asarray(down_axis(jnp.asarray(state))) * [1.0, -1.0, -1.0]
    np.testing.assert_allclose(axes[:, 2], thrust, atol=1e-6)


def _ant(position, heading, hips, ankles):
    """State [29] of brax's ant: torso, then (hip, ankle) of the legs [rad], then rates."""
    turn = [np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)]
    joints = np.stack([hips, ankles], -1).ravel()
    return np.concatenate([position, turn, joints, np.zeros(14)])


def _feet(state):
    """Lowest points [4, 3] of the legs."""
    body = Spider(Ant())
    poses = body.poses(state)
    root, feet = poses[ROOT], []
    for part in ("part4", "part7", "part10", "part13"):
        solids = np.concatenate([piece.mesh.vertices for piece in body.pieces()[part]])
        inner = solids @ _axes(poses[part]).T + poses[part].position
        points = inner @ _axes(root).T + root.position
        feet.append(points[points[:, 2].argmin()])
    return np.stack(feet)


STANDING = np.array([1.0, -1.0, -1.0, 1.0])
"""Angles of the ankles [rad]."""


def test_a_standing_ant_has_its_feet_on_the_ground():
    feet = _feet(_ant([0.5, -1.0, 0.55], 0.3, np.zeros(4), STANDING))
    assert np.abs(feet[:, 2]).max() < 0.06
    around = np.arctan2(feet[:, 1] + 1.0, feet[:, 0] - 0.5) - 0.3
    np.testing.assert_allclose(
        np.sort(np.mod(around, 2 * np.pi)), np.pi / 4 + np.pi / 2 * np.arange(4), atol=0.02
    )


def test_the_legs_of_the_ant_move_with_their_joints():
    still = _feet(_ant([0.0, 0.0, 0.55], 0.0, np.zeros(4), STANDING))
    swung = _feet(_ant([0.0, 0.0, 0.55], 0.0, np.array([0.4, 0.0, 0.0, 0.0]), STANDING))
    moved = np.linalg.norm(swung - still, axis=1)
    assert moved[0] > 0.1
    assert moved[1:].max() < 1e-6


def test_rotors_turn_in_pairs_and_faster_under_more_thrust():
    robot, body = Quadrotor(), body_of(ENVS["quadrotor"])
    states = np.stack([_rest("quadrotor", [0.0, 0.0, 2.0])] * 11)
    turns = []
    for thrust in (0.0, 0.5):
        actions = np.tile([thrust, 0.0, 0.0, 0.0], (10, 1)).astype(np.float32)
        turns.append(body.track(states, actions)[-1, robot.state_size :])
    slow, fast = turns
    np.testing.assert_array_equal(np.sign(slow), [1, -1, 1, -1])
    np.testing.assert_allclose(np.abs(slow), np.abs(slow[0]), rtol=1e-5)
    assert (np.abs(fast) > 1.1 * np.abs(slow)).all()
