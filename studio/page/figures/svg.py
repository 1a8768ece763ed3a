"""Pieces of HTML and SVG as text. Every text given by a user goes through `escape`."""

import html

from studio.theme import MONO, MONO_WIDTH


def escape(text: str) -> str:
    """Make text safe inside elements and inside quoted attributes."""
    return html.escape(text, quote=True)


def text(  # noqa: PLR0913
    x: float,
    y: float,
    content: str,
    *,
    size: float = 11,
    anchor: str = "start",
    color: str = "var(--mantine-color-text)",
    weight: int = 400,
    mono: bool = False,
    extra: str = "",
) -> str:
    """A line of text; (x, y) is on its baseline [px]."""
    family = f' font-family="{MONO}"' if mono else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" '
        f'font-weight="{weight}" style="fill:{color}"{family} {extra}>{escape(content)}</text>'
    )


def mono_width(content: str, size: float) -> float:
    """Width of monospaced text [px]."""
    return len(content) * MONO_WIDTH * size


def document(width: float, height: float, parts: list[str], label: str) -> str:
    """An SVG image that shrinks to the panel's width but does not grow beyond its own."""
    return (
        f'<svg role="img" aria-label="{escape(label)}" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'style="display:block;width:100%;max-width:{width:.0f}px;height:auto" '
        f'xmlns="http://www.w3.org/2000/svg">{"".join(parts)}</svg>'
    )
