"""Mutated project files, as an upload on the page reads them, and configurations of runs."""

import random
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec

from scenes import format_scene, load_task, task_names
from studio.page.files.projects import read_upload
from studio.runs.config import make_config, read_config
from studio.runs.tasks import ground_scene
from tests.tools.attack.table import Row
from tests.tools.trials import tried

_PIECES = (
    b"[", b"]", b"{", b"}", b'"', b"'", b'"""', b"'''", b"\\", b"#", b"=", b".", b",", b"\n", b"\r",
    b"\0", b"\xff", b"\xed\xa0\x80", b"nan", b"-inf", b"1e400", b"1e-320", b"-0.0", b"0x", b"1_",
    b"9" * 400, b"9" * 5000, b"[[", b"[regions.", b"a." * 500, b"[" * 2000, b"{a=" * 500, b"true",
    b"1979-05-27", b"F_[0:1000000](", b"!(" * 70, b"\\ud800", b"\\U00110000", "é∞".encode(),
)  # fmt: skip


def attack(count: int, seconds: float) -> list[Row]:
    """Bytes, lines and values changed; and files that repeat one thing up to the largest size."""
    share = seconds / 3
    with tempfile.TemporaryDirectory(prefix="tgpo-configs-") as parent:
        folder = Path(parent)

        def read_run(data: bytes) -> None:
            (folder / "config.json").write_bytes(data)
            read_config(folder)

        return [
            tried("files", "mutated", mutated(), _read, count=min(count, 20_000), seconds=share),
            tried("files", "repeated", repeated(), _read, count=count, seconds=share),
            tried("files", "configs", configs(), read_run, count=min(count, 5_000), seconds=share),
        ]


def mutated() -> Iterator[bytes]:
    """Shipped projects with one to four changes."""
    rng = random.Random(0)
    sources = [format_scene(load_task(name)).encode() for name in task_names()]
    while True:
        data = rng.choice(sources)
        for _ in range(rng.randint(1, 4)):
            data = rng.choice(_CHANGES)(data, rng)
        yield data


def configs() -> Iterator[bytes]:
    """Files config.json with one to four changes."""
    rng = random.Random(1)
    good = msgspec.json.encode(make_config(load_task("linear-08")).document())
    good = msgspec.json.format(good, indent=2)
    while True:
        data = good
        for _ in range(rng.randint(1, 4)):
            data = rng.choice(_CHANGES)(data, rng)
        yield data


def repeated() -> Iterator[bytes]:
    """Files of the largest size, and small ones, made of one piece."""
    good = format_scene(load_task("linear-08")).encode()
    for size in (60_000, 240_000):
        for piece in (*_PIECES, b"[[a]]\n", b"[a.b]\n", b"a.b=1\n", b"a={", b"[],", b"1,", b"#\n"):
            yield piece * (size // len(piece))
            yield good + piece * (size // len(piece))
            yield b"a = [" + piece * (size // len(piece))
        yield b"".join(b"[a%d]\n" % number for number in range(size // 10))
        yield good.replace(b"formula = ", b"formula = '''" + b"x" * size + b"'''\n#")


def _flip(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :]


def _cut(data: bytes, rng: random.Random) -> bytes:
    first, last = sorted(rng.choices(range(len(data)), k=2))
    return data[:first] + data[last:] or b"#"


def _insert(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + rng.choice(_PIECES) + data[at:]


def _swap_lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    first, second = rng.choices(range(len(lines)), k=2)
    lines[first], lines[second] = lines[second], lines[first]
    return b"\n".join(lines)


def _other_value(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    at = rng.randrange(len(lines))
    name, mark, _ = lines[at].partition(b"=")
    lines[at] = name + mark + b" " + rng.choice(_PIECES)
    return b"\n".join(lines)


def _other_number(data: bytes, rng: random.Random) -> bytes:
    digits = [at for at, byte in enumerate(data) if 48 <= byte < 58]
    if not digits:
        return data
    at = rng.choice(digits)
    number = rng.choice((b"0", b"-1", b"1e300", b"9" * 400, b"1e-320", b"inf", b"999999"))
    return data[:at] + number + data[at + 1 :]


_CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _flip,
    _cut,
    _insert,
    _swap_lines,
    _other_value,
    _other_number,
)


def _read(data: bytes) -> None:
    ground_scene(read_upload("mine.stl.toml", data))
