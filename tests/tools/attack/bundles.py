"""Mutated bundles: damaged archives, and whole archives with damaged files in them."""

import io
import json
import random
import zipfile
from collections.abc import Iterator
from functools import cache
from typing import Any

from scenes import load_task
from studio.export.archives import bundle_zip, read_policy_zip
from studio.runs.pretrained import shipped_weights
from studio.runs.tasks import build_task
from tests.tools.attack.files import mutated
from tests.tools.attack.table import Row
from tests.tools.trials import tried

_NUMBERS = (0, -1, 1, 2, 10**4, 10**7, 2**31, 2**63, 10**400, 0.5, -0.5, 1e300, 1e-300)
_VALUES = (*_NUMBERS, None, True, "x", "", [], {}, [[]], {"a": {}}, [0], [5000, 5000], [1] * 1000)


def attack(count: int, seconds: float) -> list[Row]:
    """Bytes of the archive; its metadata; its weights, programs and project."""
    share, each = seconds / 4, -(-min(count, 5_000) // 4)
    _good()  # made once, takes seconds
    kinds = {
        "archives": archives,
        "metadata": metadata,
        "weights": weights,
        "projects": projects,
    }
    return [
        tried("bundles", what, make(), _read, count=each, seconds=share)
        for what, make in kinds.items()
    ]


def archives() -> Iterator[bytes]:
    """Archives with flipped bytes, cut off, or with bytes put in."""
    rng, good = random.Random(0), _good()
    while True:
        data = bytearray(good)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(data))
            if rng.random() < 0.5:  # the directory, at the end
                at = max(0, len(data) - 1 - rng.randrange(700))
            match rng.randrange(4):
                case 0 | 1:
                    data[at] = rng.randrange(256)
                case 2:
                    data[at : at + rng.randrange(100)] = rng.randbytes(rng.randrange(100))
                case 3:
                    del data[at:]
                    data.append(0)
        yield bytes(data)


def metadata() -> Iterator[bytes]:
    """Fields of metadata.json with other values; hyper-parameters above all."""
    rng = random.Random(1)
    text = zipfile.ZipFile(io.BytesIO(_good())).read("metadata.json")
    while True:
        values = json.loads(text)
        values.pop("sha256")
        for _ in range(rng.randint(1, 2)):
            table = rng.choice((values, values["algorithm"], values["algorithm"]))
            if not isinstance(table, dict):
                continue
            table[rng.choice(list(table))] = rng.choice(_VALUES)
            if not isinstance(values["algorithm"], dict):
                break
        data = json.dumps(values).encode()
        if rng.random() < 0.3:
            data = _damaged(data, rng)
        yield _with("metadata.json", data)


def weights() -> Iterator[bytes]:
    """Weights with damaged headers and data."""
    rng = random.Random(2)
    good = zipfile.ZipFile(io.BytesIO(_good())).read("weights.safetensors")
    size = int.from_bytes(good[:8], "little")
    header = json.loads(good[8 : 8 + size])
    while True:
        match rng.randrange(4):
            case 0:
                data = _damaged(good[: 8 + size], rng) + good[8 + size :]
            case 1:
                data = _with_header(_changed(header, rng), good[8 + size :])
            case 2:
                nested = rng.choice(("[", '{"a":', '{"keys":{"a":')) * rng.choice((10, 200_000))
                data = _with_header(header | {"__metadata__": {"tgpo-studio": nested}}, b"")
            case _:
                data = _damaged(good, rng)
        yield _with("weights.safetensors", data)


def projects() -> Iterator[bytes]:
    """Bundles with a damaged project."""
    for data in mutated():
        yield _with("task.stl.toml", data)


def _changed(header: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """Another shape, type or place of one array."""
    name = rng.choice([name for name in header if name != "__metadata__"])
    field, value = rng.choice(
        (
            ("shape", rng.choice(([5000, 5000], [2**62, 8], [-1], [], [0]))),
            ("dtype", rng.choice(("F64", "BF16", "U8", "F8_E4M3", "x", "BOOL"))),
            ("data_offsets", rng.choice(([0, 2**62], [8, 0], [0, 0], [-1, 4]))),
        )
    )
    return header | {name: header[name] | {field: value}}


def _with_header(header: dict[str, Any], data: bytes) -> bytes:
    text = json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + data


def _damaged(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.randint(1, 3)):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed[: rng.randrange(len(changed))] if rng.random() < 0.2 else changed)


def _with(name: str, data: bytes) -> bytes:
    """The good bundle, stored, with one other file."""
    packed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(_good())) as old, zipfile.ZipFile(packed, "w") as new:
        for member in old.namelist():
            new.writestr(member, data if member == name else old.read(member))
    return packed.getvalue()


@cache
def _good() -> bytes:
    scene = load_task("linear-08")
    weights = shipped_weights(build_task(scene))
    assert weights is not None
    return bundle_zip(weights.policy(scene))


def _read(data: bytes) -> None:
    read_policy_zip("mine.zip", data)
