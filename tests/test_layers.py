"""Imports go one way: core <- envs, core.stl <- scenes, everything <- studio."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {"core", "envs", "scenes", "studio", "static", "tests"}
ALLOWED = {
    "core": {"core"},
    "envs": {"envs", "core"},
    "scenes": {"scenes", "core.stl", "core.errors"},
    "studio": {"studio", "core", "envs", "scenes", "static"},
}


def _imports(path: Path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def _offences(package: str, root: Path) -> list[str]:
    found = []
    for path in sorted((root / package).rglob("*.py")):
        for module in _imports(path):
            ours = module.split(".")[0] in PACKAGES
            prefixes = {".".join(module.split(".")[: i + 1]) for i in range(module.count(".") + 1)}
            if (ours and not prefixes & ALLOWED[package]) or (
                module.split(".")[0] == "viser" and package != "studio"
            ):
                found.append(f"{path.relative_to(root)} imports {module}")
    return found


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_imports_go_one_way(package):
    assert _offences(package, ROOT) == []


def test_a_wrong_import_is_seen(tmp_path):
    (tmp_path / "core").mkdir()
    (tmp_path / "core" / "bad.py").write_text("from scenes import Scene\nimport viser\n")
    assert len(_offences("core", tmp_path)) == 2
