import html
import re
from dataclasses import replace

import pytest

from core.stl import parse
from envs import ENVS
from scenes import load_task
from studio.page.panels.palette import OPERATORS, examples, palette_html
from tests.studio.conftest import EVIL


def test_names_cannot_run_code(evil_scene):
    drawn = palette_html(evil_scene)
    assert EVIL not in drawn
    assert html.escape(EVIL) in drawn


def test_every_name_is_offered_as_the_formula_needs_it():
    scene = load_task("linear-08")
    named = replace(scene, regions=(replace(scene.regions[0], name="my home"), *scene.regions[1:]))
    scripts = [
        html.unescape(text) for text in re.findall(r'onclick="([^"]*)"', palette_html(named))
    ]
    assert len(scripts) == len(OPERATORS) + len(named.regions)
    assert any('t="\\"my home\\""' in script for script in scripts)


@pytest.mark.parametrize("task", ["linear-08", "unicycle-03"])
def test_the_examples_can_be_read_over_the_scene(task):
    scene = load_task(task)
    offered = examples(scene.robot, scene.region_names)
    assert scene.formula in offered.values()
    for formula in offered.values():
        parse(formula, dt=ENVS[scene.robot].dt, names=scene.region_names)


def test_a_scene_without_their_regions_is_offered_none():
    assert examples("linear", ("X",)) == {}
