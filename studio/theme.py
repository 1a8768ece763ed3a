"""Colours and styles of the page."""

from core.decompose import Kind

BRAND = (30, 96, 145)

MONO = "ui-monospace, SFMono-Regular, Menlo, Consolas, 'DejaVu Sans Mono', monospace"
MONO_WIDTH = 0.602
"""Width of a character of `MONO`, relative to the font size."""

GOOD, BAD, TIME, MUTED = "#2b8a3e", "#c92a2a", "#c2255c", "var(--mantine-color-dimmed)"
TRAIL = (247, 103, 7)

KIND_COLOR = {Kind.REACH: "#1e6091", Kind.STAY: "#0b7285", Kind.INVARIANT: "#8a4b22"}
"""Ink of a task's label and frame."""

KIND_FILL = {Kind.REACH: "#dcecf8", Kind.STAY: "#d9f2f3", Kind.INVARIANT: "#f8e9dc"}
"""Its background."""


def themed(name: str, light: str) -> str:
    """A colour of the light theme; in the dark theme, what `STYLE` calls `--tg-<name>`."""
    return f"var(--tg-{name}, {light})"


STYLE = """
<style>
[data-mantine-color-scheme="dark"] { --tg-time: #f783ac; --tg-good: #69db7c; --tg-bad: #ff8787;
  --tg-reach-fill: #17344b; --tg-reach-ink: #8ec5ee; --tg-stay-fill: #123b40;
  --tg-stay-ink: #74d3df; --tg-invariant-fill: #45301f; --tg-invariant-ink: #eab98f;
  --tg-holding: #1d3323; --tg-met: #24512f; --tg-violated: #5c2323; }
[data-mantine-color-scheme="dark"] .tg-error { background: #3b1d1d; color: #ffb3b3; }
[data-mantine-color-scheme="dark"] .tg-warn { background: #3a2a10; color: #ffd591; }
[data-mantine-color-scheme="dark"] .tg-tour,
[data-mantine-color-scheme="dark"] .tg-info { background: #142c3d; color: #b5d9f2; }
[data-mantine-color-scheme="dark"] [role="tab"][data-active] { color: #74b6e4; }
.tg { padding: 0 0.75em 0.6em; font-size: 0.875em; line-height: 1.45;
  color: var(--mantine-color-text); }
.tg-dim { color: var(--mantine-color-dimmed); }
.tg-title { font-weight: 600; }
.tg-mono, .tg pre, .mantine-Textarea-input {
  font-family: ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace
  !important; }
.mantine-Textarea-input { font-size: 12px !important; line-height: 1.5 !important; }
.tg pre { margin: 0; font-size: 12px; white-space: pre-wrap; overflow-wrap: anywhere; }
.tg-note { border-left: 3px solid; border-radius: 3px; padding: 0.45em 0.65em; }
.tg-error { border-color: #c92a2a; background: #fff0f0; color: #8f1d1d; }
.tg-error pre { white-space: pre; overflow-x: auto; }
.tg-warn { border-color: #e8890c; background: #fff6e6; color: #7a4a05; }
.tg-info { border-color: #1e6091; background: #eaf3fa; color: #17445f; }
.tg-english { margin: 0; padding: 0 0 0 1.1em; max-height: 15em; overflow-y: auto;
  overflow-wrap: anywhere; list-style: disc; }
.tg-english li + li { margin-top: 0.15em; }
.tg-scroll { overflow-x: auto; }
.tg-badge { display: inline-block; border-radius: 999px; padding: 0.1em 0.75em; font-weight: 600;
  color: #fff; }
.tg-cards { display: grid; grid-template-columns: repeat(3, 1fr); gap: 0.4em; }
.tg-tour { border-color: #1e6091; background: #eaf3fa; color: #17445f; margin-top: 0.5em; }
.tg-card { background: var(--mantine-color-default-hover);
  border: 1px solid var(--mantine-color-default-border);
  border-radius: 4px; padding: 0.3em 0.5em; }
.tg-card b { display: block; font-size: 1.2em; font-weight: 600; white-space: nowrap; }
.tg-card span { color: var(--mantine-color-dimmed); font-size: 0.85em; white-space: nowrap; }
.tg table { border-collapse: collapse; width: 100%; font-size: 12px; }
.tg th { text-align: left; font-weight: 500; color: var(--mantine-color-dimmed);
  border-bottom: 1px solid var(--mantine-color-default-border); padding: 0.15em 0.6em 0.15em 0; }
.tg td { padding: 0.2em 0.6em 0.2em 0; border-bottom: 1px solid var(--mantine-color-default-border);
  vertical-align: top; }
.tg-dot { display: inline-block; width: 0.7em; height: 0.7em; border-radius: 2px;
  margin-right: 0.45em; vertical-align: -0.02em; }
.mantine-Flex-root:has(> div textarea) { flex-direction: column;
  align-items: stretch !important; }
.mantine-Flex-root:has(> div textarea) > div:first-child { width: 100% !important;
  padding-bottom: 0.25em; }
.tg-transport { display: flex; gap: 0.4em; align-items: center; }
.tg-transport button { font: inherit; font-size: 0.95em; cursor: pointer; border-radius: 4px;
  border: 1px solid var(--mantine-color-default-border); background: var(--mantine-color-body);
  color: var(--mantine-color-text); padding: 0.15em 0.7em; min-width: 2.6em; }
.tg-transport button:hover { background: var(--mantine-color-default-hover); }
.tg-transport button[aria-pressed="true"] { background: #1e6091; border-color: #1e6091;
  color: #fff; }
.tg-transport .tg-gap { flex-grow: 1; }
.tg-leaf { cursor: pointer; }
.tg-leaf rect { transition: fill 0.2s; }
.tg-leaf:hover rect { stroke-opacity: 1; stroke-width: 1.8; }
.tg-legend { margin-top: 0.45em; display: flex; gap: 0.35em; align-items: center;
  overflow-x: auto; white-space: nowrap; padding: 2px; }
.tg-legend > * { flex: none; }
.tg-chip { font: inherit; font-size: 0.9em; cursor: pointer; border-radius: 999px; color: inherit;
  border: 1px solid var(--mantine-color-default-border); background: transparent;
  padding: 0 0.7em; }
.tg-chip[aria-pressed="true"] { border-color: #1e6091; box-shadow: 0 0 0 1px #1e6091; }
.tg-chip .tg-dot { border-radius: 50%; }
.tg-sample { font-weight: 600; }
.tg-rows { max-height: 220px; overflow-y: auto; margin: 0.35em 0 0.25em; }
.tg-rows image { image-rendering: pixelated; cursor: pointer; }
.tg-readout { min-height: 1.45em; white-space: nowrap; overflow: hidden; text-overflow: ellipsis;
  font-variant-numeric: tabular-nums; }
.tg-chips { display: flex; flex-wrap: wrap; gap: 0.3em; align-items: center; }
.tg-together { display: inline-flex; gap: inherit; margin-left: auto; }
.tg-chips button { font: inherit; font-size: 0.93em; cursor: pointer; border-radius: 4px;
  border: 1px solid var(--mantine-color-default-border); background: var(--mantine-color-body);
  color: var(--mantine-color-text); padding: 0.1em 0.55em; white-space: nowrap; }
.tg-chips button:hover:not(:disabled) { border-color: #1e6091; }
.tg-chips button:disabled { opacity: 0.4; cursor: default; }
.tg-chips button[aria-pressed="true"] { background: #1e6091; border-color: #1e6091; color: #fff; }
.tg-chips .tg-gap { flex-grow: 1; }
.tg-chips + .tg-chips { margin-top: 0.45em; }
.tg-map .tg-readout { white-space: normal; min-height: 2.9em; }
.tg-heat image { cursor: crosshair; image-rendering: pixelated; }
</style>
"""
"""Added to the page once. The page's own classes start with `tg`."""
