"""Nothing that a person named reaches the page as markup: viser's HTML runs event handlers."""

from html.parser import HTMLParser

import numpy as np
import pytest

from studio.page.editing.specification import specify
from studio.page.figures.monitor import monitor_html
from studio.page.figures.tables import abbreviation_list, task_table
from studio.page.figures.timeline import timeline_svg
from studio.page.figures.tree import tree_svg
from studio.page.panels.formula import _reading
from studio.page.panels.html import note
from studio.page.panels.rollout import verdict_html
from studio.page.panels.task import _about
from studio.runs.recording import record
from tests.studio.conftest import EVIL

ACTIVE = {"monitor", "tree"}
"""Figures with handlers of their own, in which no name may stand."""


class _Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags, self.handlers, self.scripts, self.text = set(), [], "", ""

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        self.scripts += "".join(value or "" for name, value in attrs if name.startswith("on"))

    def handle_data(self, data):
        self.text += data


def parsed(html):
    parser = _Tags()
    parser.feed(html)
    parser.close()
    return parser


@pytest.fixture
def specification(evil_scene):
    specification = specify(evil_scene)
    assert specification.error == ""
    return specification


@pytest.fixture
def recording(specification):
    task = specification.task
    margins = np.full((task.padded_horizon + 1, 32), -1.0)
    margins[:, task.grounding.atoms.index("A2")] = 1.0
    states, actions = np.zeros((task.padded_horizon + 1, 2)), np.zeros((task.padded_horizon, 2))
    return record(task, (10, 50), states, actions, margins)


@pytest.fixture
def pieces(specification, recording):
    decomposition = specification.decomposition
    wrong = specify(specification.scene, f'F_[0:90]("{EVIL}" &')
    unknown = specify(specification.scene, 'F_[0:90]("<b>")')
    return {
        "tree": tree_svg(decomposition),
        "table": task_table(decomposition),
        "timeline": timeline_svg(recording),
        "monitor": monitor_html(recording, "here()"),
        "verdict": verdict_html(recording),
        "reading": _reading(specification),
        "about": _about(specification.scene),
        "error": note(wrong.error),
        "unknown": note(unknown.error),
    }


def test_names_are_text(pieces):
    for name, html in pieces.items():
        parser = parsed(html)
        assert "img" not in parser.tags, name
        assert name in ACTIVE or not parser.handlers, name
        assert "alert" not in parser.scripts, name
        if name != "timeline":  # which cuts long names
            assert EVIL in parser.text, name


def test_the_parser_would_notice_markup():
    parser = parsed(f"<div>{EVIL}</div>")
    assert "img" in parser.tags
    assert parser.handlers == ["onerror"]
    assert "alert" in parser.scripts


def test_abbreviations_are_text(specification):
    text = f'F_[0:90](A2 & F_[0:50]("{EVIL}"))'
    nested = specify(specification.scene, text)
    assert nested.error == ""
    assert nested.decomposition is not None
    parser = parsed(abbreviation_list(nested.decomposition))
    assert EVIL in parser.text
    assert "img" not in parser.tags
