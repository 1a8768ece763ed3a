import re
import xml.etree.ElementTree as ET

import pytest

from core.decompose import decompose
from core.stl import parse
from scenes import load_task, task_names
from studio.page.figures.tables import task_table
from studio.page.figures.tree import abbreviations, tree_svg
from studio.runs.tasks import decompose_scene


def texts(svg):
    return [node.text for node in ET.fromstring(svg).iter() if node.tag.endswith("text")]


def test_linear_08():
    decomposition = decompose_scene(load_task("linear-08"))
    assert texts(tree_svg(decomposition)) == [
        "Reach(φ, 0)",
        "t1 ∈ [0, 90]",
        "Reach(A1, t1)",
        "t2 ∈ [40, 80]",
        "Reach(φ₀, t2)",
        "Reach(A2, t2)",
        "t3 ∈ [10, 20]",
        "Inv(A3, [t2+t3, t2+t3+10])",
        "Inv(¬B1, ¬B2, …, ¬B5, [0, 100])",
    ]
    assert abbreviations(decomposition) == [("φ₀", "A2 ∧ ◇[10,20](□[0,10](A3))")]


def test_branches_name_their_choice():
    drawn = texts(tree_svg(decompose(parse("F_[0:5](A) | G_[0:5](B)"))))
    assert "b1 = 0" in drawn
    assert "b1 = 1" in drawn


def test_invariants_over_different_windows_stay_apart():
    drawn = texts(tree_svg(decompose(parse("G_[0:5](!A) & G_[0:5](!B) & G_[1:5](!C)"))))
    assert drawn[1:] == ["Inv(¬A, ¬B, [0, 5])", "Inv(¬C, [1, 5])"]


@pytest.mark.parametrize("name", task_names())
def test_every_shipped_tree_is_a_well_formed_picture_with_all_its_text_inside(name):
    root = ET.fromstring(tree_svg(decompose_scene(load_task(name))))
    _, _, width, height = map(float, root.attrib["viewBox"].split())
    for node in root.iter():
        if node.tag.endswith("rect"):
            right = float(node.attrib["x"]) + float(node.attrib["width"])
            bottom = float(node.attrib["y"]) + float(node.attrib["height"])
            assert right <= width
            assert bottom <= height
    assert height < 600


def test_the_table_joins_invariants_over_one_window():
    table = task_table(decompose_scene(load_task("linear-08")))
    rows = re.findall(r"<tr>(.*?)</tr>", table)
    cells = [re.sub(r"<[^>]*>", "", cell) for cell in re.findall(r"<td>(.*?)</td>", rows[-1])]
    assert cells == ["Invariants (5)", "¬B1, ¬B2, ¬B3, ¬B4, ¬B5", "0", "100"]
    assert len(rows) == 5
    assert "<th>If</th>" not in table


def test_the_table_tells_the_branch():
    table = task_table(decompose(parse("F_[0:5](A) | G_[0:5](B)")))
    assert "<th>If</th>" in table
    assert "b1 = 0" in table
