"""Robots bring their variants."""

import pytest

from core.errors import UserError
from envs import ENVS, VARIANTS, make_robot


def test_variants_of_the_shipped_robots():
    assert dict(VARIANTS) == {
        "linear": (),
        "unicycle": (),
        "panda": ("links",),
        "quadrotor": ("raw-motors",),
        "ant": ("native", "mjx", "brax"),
    }


@pytest.mark.parametrize("name", ENVS)
def test_a_variant_is_another_reading_of_the_same_robot(name):
    assert make_robot(name) is ENVS[name]
    for variant in VARIANTS[name]:
        robot = make_robot(name, variant)
        assert robot.name == name
        assert robot.workspace == ENVS[name].workspace
        assert robot != ENVS[name]
        assert hash(robot) == hash(make_robot(name, variant))


@pytest.mark.parametrize(
    ("name", "variant", "message"),
    [
        ("car", "", "robot: unknown 'car'. Allowed: linear, unicycle, panda, quadrotor, ant"),
        ("panda", "link", "variant: unknown 'link' of 'panda'. Allowed: links"),
        ("panda", "mjx", "variant: unknown 'mjx' of 'panda'. Allowed: links"),
        ("linear", "links", "variant: unknown 'links' of 'linear'. Allowed: none"),
        ("ant", "mj", "variant: unknown 'mj' of 'ant'. Allowed: mjx, native, brax"),
        ("ant", ["mjx"], r"variant: unknown ['mjx'] of 'ant'"),
        (["ant"], "", "robot: unknown ['ant']"),
    ],
)
def test_what_is_unknown_is_named_with_what_is_allowed(name, variant, message):
    with pytest.raises(UserError) as error:
        make_robot(name, variant)
    assert message in str(error.value)
