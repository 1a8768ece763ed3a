"""Headless runs killed at any moment: they resume, and end as if nothing had happened."""

import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.tools.attack.table import Row

EPOCHS = 30

_ROOT = Path(__file__).parents[3]

_CHILD = """
import sys
from core.methods.tgpo import method
from studio.cli import main
from studio.runs import run
from tests.small import shrink

original = method.make_algorithm
method.make_algorithm = lambda *given: shrink(original(*given))
run.CHECKPOINT_SECONDS = 0.0
sys.exit(main(sys.argv[1:]))
"""


def attack(count: int, seconds: float) -> list[Row]:
    """Kill at most 50 times, at random moments of starting, training and saving."""
    rng, until = random.Random(0), time.monotonic() + seconds
    kills = failures = 0
    slowest = 0.0
    with tempfile.TemporaryDirectory(prefix="tgpo-kills-") as parent:
        whole = Path(parent) / "whole"
        _, startup = _to_the_end(whole)
        while kills < min(count, 50) and time.monotonic() < until:
            folder = Path(parent) / f"run-{kills}"
            while kills < min(count, 50) and time.monotonic() < until:
                if _ended(folder, rng, startup):
                    break
                kills += 1
            status, took = _to_the_end(folder)
            slowest = max(slowest, took)
            problem = f"exit status {status}" if status else _difference(folder, whole)
            if problem:
                failures += 1
                print(f"kills: {folder.name}: {problem}", file=sys.stderr)
    return [Row("kills", "headless", kills, 0, failures, slowest, 0.0)]


def _ended(folder: Path, rng: random.Random, startup: float) -> bool:
    """Run for a while, then kill; whether the run had ended by itself."""
    with _start(folder) as process:
        assert process.stdout is not None
        if rng.random() < 0.3:
            time.sleep(rng.random() * startup)
        elif process.stdout.readline():  # the first epoch
            time.sleep(rng.expovariate(4))
        ended = process.poll() == 0
        process.kill()
    return ended


def _to_the_end(folder: Path) -> tuple[int, float]:
    """Exit status, and the time [s]."""
    began = time.monotonic()
    with _start(folder) as process:
        _, errors = process.communicate()
    if process.returncode:
        print(errors, file=sys.stderr)
    return process.returncode, time.monotonic() - began


def _start(folder: Path) -> subprocess.Popen:
    """Begin the run, or resume it."""
    if (folder / "config.json").exists():
        arguments = ["--resume", str(folder)]
    else:
        arguments = ["--train-only", "--task", "linear-08", "--target", "2", "--seed", "3"]
        arguments += ["--epochs", str(EPOCHS), "--out", str(folder)]
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, "-c", _CHILD, *arguments], cwd=_ROOT, stdout=pipe, stderr=pipe, text=True
    )


def _difference(folder: Path, whole: Path) -> str:
    """What tells a resumed run from the uninterrupted one; empty if nothing does."""
    weights = "bundle/weights.safetensors"
    if (folder / weights).read_bytes() != (whole / weights).read_bytes():
        return "the weights differ"
    if _metrics(folder) != _metrics(whole):
        return "the metrics differ"
    left = [path.name for path in folder.rglob("*.tmp")]
    return f"left behind: {left}" if left else ""


def _metrics(folder: Path) -> list[dict]:
    """Lines of the metrics without times."""
    lines = (folder / "metrics.jsonl").read_text().splitlines()
    return [
        {name: value for name, value in json.loads(line).items() if not name.endswith("_seconds")}
        for line in lines
    ]
