"""The paper's published figures, `published.toml`, to stand beside one's own."""

from functools import cache
from importlib import resources

import msgspec


class Published(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Success rates."""

    citation: str
    stated: tuple[str, ...]
    """`robot/method` of figures that the text states; the others are read off a chart."""
    success: dict[str, dict[str, float]]
    """By robot and method."""
    horizon: dict[str, float]
    """Of TGPO* on the two-layer Linear tasks, by number of steps."""
    sampling: dict[str, tuple[float, float]]
    """By variant of the ablation (Table 1a): mean and standard deviation over seeds."""
    parts: dict[str, tuple[float, float]]
    """By parts of state and reward (Table 1b), the same."""


@cache
def published() -> Published:
    """The figures."""
    text = (resources.files("studio.bench") / "published.toml").read_bytes()
    return msgspec.toml.decode(text, type=Published)
