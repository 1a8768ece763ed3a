"""`--explain`, and what is said of a formula that does not decompose."""

from dataclasses import replace

import pytest

from core.errors import UserError
from scenes import load_task
from studio.cli import main
from studio.runs.tasks import decompose_scene

SCENE = load_task("linear-08")


def test_a_task_is_explained(capsys):
    assert main(["--explain", "--task", "linear-08"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("F_[0:90](A1) & F_[40:80](A2 & ")
    assert "Between 8 s and 16 s be in A2, and 2 to 4 s later stay 2 s in A3." in lines
    assert any(line.startswith("Subgoal 2") for line in lines)


def test_what_the_text_left_open_goes_to_standard_error(capsys):
    assert main(["--explain", "--task", "linear-08", "--formula", "F A1 & G !B5 # both"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("F_[0:100](A1) & G_[0:100](!B5)\n")
    assert "reach to the scene's horizon, 100 steps" in captured.err


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (["--formula", "F_[0:5](x > 3)"], "`x > 3` (columns 9-13) compares numbers"),
        (["--epochs", "3"], "--epochs cannot be used with --explain"),
    ],
)
def test_bad_input(capsys, option, words):
    assert main(["--explain", "--task", "linear-08", *option]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "typed", "place"),
    [
        (
            "A1 &  G_[0:999]((A2  until[0:3] A3))",
            "G_[0:999]((A2 until[0:3] A3))",
            "columns 7-36",
        ),
        (
            "A1\n& □[0,999]((A2) U[0,3] A3)",
            "□[0,999]((A2) U[0,3] A3)",
            "line 2, columns 3-26",
        ),
        (
            "G_[0:999]((A2 |\n A1)\n until[0:3] A3)",
            "G_[0:999]((A2 | A1) until[0:3] A3)",
            "line 1, column 1 to line 3, column 15",
        ),
    ],
)
def test_a_refusal_quotes_the_text_as_typed_and_offers_a_stronger_formula(text, typed, place):
    scene = replace(SCENE, formula=text)
    with pytest.raises(UserError) as caught:
        decompose_scene(scene)
    message = str(caught.value)
    assert message.startswith(f"cannot decompose `{typed}` ({place}): ")
    offer = message.partition("Stronger, and it decomposes: ")[2]
    assert decompose_scene(replace(scene, formula=offer)).tasks


def test_a_part_that_was_written_otherwise_is_shown_in_normal_form_too():
    with pytest.raises(UserError) as caught:
        decompose_scene(replace(SCENE, formula="A1 & !F_[0:999](!F_[0:3](A2))"))
    message = str(caught.value)
    assert "`!F_[0:999](!F_[0:3](A2))` (columns 6-29), that is `G_[0:999](F_[0:3](A2))`" in message


def test_nothing_is_offered_where_nothing_is_found():
    with pytest.raises(UserError) as caught:
        decompose_scene(replace(SCENE, formula="A1 & false"))
    assert "Stronger" not in str(caught.value)
