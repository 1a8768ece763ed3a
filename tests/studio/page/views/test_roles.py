import pytest

from core.decompose import decompose
from core.stl import parse
from scenes import load_task
from studio.page.views.roles import Role, roles
from studio.runs.tasks import decompose_scene


def test_keys_doors_and_walls():
    scene = load_task("linear-10")
    found = roles(scene.region_names, decompose_scene(scene))
    assert {found[name] for name in ("K1", "K2", "K3", "G")} == {Role.GOAL}
    assert {found[name] for name in ("D1", "D2", "D3")} == {Role.DOOR}
    assert {found[f"B{i}"] for i in range(1, 6)} == {Role.OBSTACLE}


@pytest.mark.parametrize(
    ("formula", "role"),
    [
        ("F_[0:5](A)", Role.GOAL),
        ("G_[0:5](A)", Role.GOAL),
        ("G_[0:5](!A)", Role.OBSTACLE),
        ("F_[0:5](G_[0:9](!A))", Role.OBSTACLE),
        ("F_[0:5](!A & B)", Role.DOOR),
        ("(!A)U_[0:5](B)", Role.DOOR),
        ("G_[0:5](!A) & F_[7:9](A)", Role.GOAL),
        ("F_[0:5](B)", Role.UNUSED),
    ],
)
def test_the_formula_decides(formula, role):
    assert roles(("A", "B"), decompose(parse(formula)))["A"] is role


def test_without_a_formula_nothing_has_a_role():
    assert roles(("A",), None) == {"A": Role.UNUSED}
