"""Imports go one way, and nowhere in a circle: core <- envs <- scenes <- studio."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {"core", "envs", "scenes", "studio", "static", "tests"}
ALLOWED = {
    "core": {"core"},
    "envs": {"envs", "core", "static"},
    "scenes": {"scenes", "core", "envs"},
    "studio/runs": {"studio.runs", "studio.options", "core", "envs", "scenes", "static"},
    "studio/export": {"studio.export", "studio.runs", "studio.theme", "core", "envs", "scenes"},
    "studio/bench": {"studio.bench", "studio.runs", "core", "envs", "scenes", "static"},
    "studio/gym": {"studio.gym", "studio.runs", "core", "envs", "scenes"},
    "studio/page": {
        "studio.page",
        "studio.export",
        "studio.runs",
        "studio.theme",
        "core",
        "envs",
        "scenes",
        "static",
    },
    "studio": {"studio", "core", "envs", "scenes", "static"},
}
"""By folder, what its modules may import; the page alone knows viser."""


def _imports(path: Path) -> Iterator[str]:
    """Modules that a file imports, `from a import b` as a.b."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _prefixes(module: str) -> set[str]:
    parts = module.split(".")
    return {".".join(parts[: count + 1]) for count in range(len(parts))}


def _offences(folder: str, root: Path) -> list[str]:
    found = []
    for path in sorted((root / folder).rglob("*.py")):
        for module in _imports(path):
            package = module.split(".")[0]
            wrong = package in PACKAGES and not _prefixes(module) & ALLOWED[folder]
            if wrong or (package == "viser" and not folder.startswith("studio")):
                found.append(f"{path.relative_to(root)} imports {module}")
    return found


def _circles(folder: Path, root: Path) -> list[str]:
    """Circles among the parts of a folder, its files and its folders, at every depth."""
    within = ".".join(folder.relative_to(root).parts)
    parts: dict[str, set[str]] = {}
    found = []
    for part in sorted(folder.iterdir()):
        files = [part] if part.suffix == ".py" else sorted(part.rglob("*.py"))
        if not files or part.name == "__init__.py":  # which hands on what its folder offers
            continue
        if part.is_dir():
            found += _circles(part, root)
        modules = [module.split(".") for path in files for module in _imports(path)]
        depth = len(folder.relative_to(root).parts)
        beside = {m[depth] for m in modules if ".".join(m[:depth]) == within and len(m) > depth}
        parts[part.stem] = beside - {part.stem}
    graph = {name: beside & set(parts) for name, beside in parts.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found.append(f"{within}: {' -> '.join(error.args[1])}")
    return found


@pytest.mark.parametrize("folder", sorted(ALLOWED))
def test_imports_go_one_way(folder):
    assert _offences(folder, ROOT) == []


@pytest.mark.parametrize("package", ["core", "envs", "scenes", "studio"])
def test_no_imports_in_a_circle(package):
    assert _circles(ROOT / package, ROOT) == []


def test_nothing_imports_the_page_but_the_command():
    importers = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "studio").rglob("*.py")
        if any("studio.page" in _prefixes(module) for module in _imports(path))
    }
    assert {name for name in importers if not name.startswith("studio/page/")} == {"studio/cli.py"}


def test_a_wrong_import_is_seen(tmp_path):
    (tmp_path / "core").mkdir()
    (tmp_path / "core" / "bad.py").write_text("from scenes import Scene\nimport viser\n")
    assert len(_offences("core", tmp_path)) == 2


def test_a_circle_is_seen(tmp_path):
    inner = tmp_path / "core" / "inner"
    inner.mkdir(parents=True)
    (tmp_path / "core" / "above.py").write_text("from core.inner.low import x\n")
    (inner / "low.py").write_text("x = 1\n")
    assert _circles(tmp_path / "core", tmp_path) == []
    (inner / "low.py").write_text("def f():\n    from core import above\n")
    assert len(_circles(tmp_path / "core", tmp_path)) == 1
