"""The command's arguments: what is understood, and how quickly and clearly the rest is refused."""

import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import get_args, get_type_hints

import pytest

from core.errors import UserError
from core.methods import METHODS
from core.methods.bounds import ModeName
from envs import VARIANTS
from scenes import demo_names, task_names
from studio import cli
from studio.cli import Options, main
from studio.runs import commands

ROOT = Path(__file__).parents[2]


@pytest.fixture
def called(monkeypatch):
    """Which action was started, with its options."""
    calls = []
    for name in ("train_only", "resume", "evaluate"):
        monkeypatch.setattr(
            commands, name, lambda options, name=name: calls.append((name, options)) or 0
        )
    monkeypatch.setattr(cli, "_use_cache", lambda options: calls.append(options.no_cache))
    page = ModuleType("studio.page.app")
    page.serve = lambda **options: calls.append(("page", options))  # pyright: ignore
    monkeypatch.setitem(sys.modules, "studio.page.app", page)
    return calls


@pytest.mark.parametrize(
    ("arguments", "name", "expected"),
    [
        (
            "--train-only --task linear-08 --method tgpo --mode paper --seed 3 --epochs 7 "
            "--time-limit 60 --target 0.9 --out runs/x",
            "train_only",
            Options(
                train_only=True,
                task="linear-08",
                method="tgpo",
                mode="paper",
                seed=3,
                epochs=7,
                time_limit=60.0,
                target=0.9,
                out=Path("runs/x"),
            ),
        ),
        (
            "--train-only --scene a.stl.toml --formula F_[0:9](A)",
            "train_only",
            Options(train_only=True, scene=Path("a.stl.toml"), formula="F_[0:9](A)"),
        ),
        ("--resume r --epochs 9", "resume", Options(resume=Path("r"), epochs=9)),
        ("--resume r --train-only", "resume", Options(resume=Path("r"), train_only=True)),
        ("--evaluate r --task t", "evaluate", Options(evaluate=Path("r"), task="t")),
    ],
)
def test_actions(called, arguments, name, expected):
    assert main(arguments.split()) == 0
    assert called == [False, (name, expected)]


def test_the_page(called):
    assert main(["--task", "linear-01", "--port", "0", "--no-browser", "--no-cache"]) == 0
    assert called == [
        True,
        (
            "page",
            {
                "task": "linear-01",
                "scene": None,
                "formula": None,
                "host": "127.0.0.1",
                "port": 0,
                "open_browser": False,
                "load": None,
                "token": None,
            },
        ),
    ]


def test_the_tasks_are_listed(capsys):
    assert main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == demo_names() + task_names()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--train-only", "give --task NAME or --scene FILE.stl.toml"),
        ("--train-only --task a --scene b", "--task and --scene cannot be combined"),
        ("--epochs 3", "--epochs cannot be used without --train-only"),
        ("--resume r --seed 3", "--seed cannot be used with --resume. Allowed: --epochs"),
        ("--evaluate r --train-only", "--train-only cannot be used with --evaluate"),
        ("--list --task a", "--task cannot be used with --list. Allowed: nothing"),
        ("--train-only --task a --port 1", "--port cannot be used with --train-only"),
        ("--port 70000", "--port: 70000 must be from 0 to 65535"),
    ],
)
def test_contradictions_are_refused(capsys, arguments, message):
    assert main(arguments.split()) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"error: {message}") and not captured.out


@pytest.mark.parametrize(
    "arguments",
    ["--method ppo", "--mode fast", "--epochs many", "--seed 1.5", "--out", "--frobnicate", "x"],
)
def test_what_cannot_be_parsed_is_refused(capsys, arguments):
    with pytest.raises(SystemExit) as stopped:
        main(arguments.split())
    assert stopped.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (UserError("line 1\nF(\n ^"), 2, "error: line 1\nF(\n ^\n"),
        (KeyboardInterrupt(), 130, "aborted\n"),
    ],
)
def test_failures_have_a_status_and_no_traceback(monkeypatch, capsys, error, status, message):
    def fail(options):
        raise error

    monkeypatch.setattr(commands, "evaluate", fail)
    assert main(["--evaluate", "x", "--no-cache"]) == status
    assert capsys.readouterr().err == message


def test_choices_are_those_of_the_core():
    hints = get_type_hints(Options)
    assert get_args(hints["method"]) == tuple(METHODS)
    assert get_args(hints["mode"]) == get_args(ModeName)


def _heavy_imports(*arguments: str) -> tuple[str, str]:
    """Output of the command, and which heavy packages it imported."""
    code = (
        f"import sys; sys.argv[1:] = {list(arguments)}\n"
        "from studio.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(sorted({'jax', 'numpy', 'viser', 'scenes'} & set(sys.modules)))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    *output, imported = done.stdout.splitlines()
    return "\n".join(output) + done.stderr, imported


def test_errors_in_arguments_need_nothing_heavy():
    for arguments in (
        ["--port", "-1"],
        ["--mode", "fast"],
        ["--task", "linear-08", "--scene", "x"],
    ):
        output, imported = _heavy_imports(*arguments)
        assert arguments[0] in output and imported == "[]"


def test_help_asks_the_robots_for_their_variants_and_needs_nothing_else():
    output, imported = _heavy_imports("--help")
    assert "--train-only" in output
    assert imported == "['jax', 'numpy']"
    words = output.replace("│", " ").split()
    text = " ".join(words)
    for robot, variants in VARIANTS.items():
        assert not variants or f"{robot}: {', '.join(variants)}" in text


def test_python_m_studio():
    command = [sys.executable, "-m", "studio", "--port", "-1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stderr.startswith("error: --port: -1 must be")
