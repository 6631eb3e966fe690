"""The road runs one way, the folders know only what they may, and every test can fail."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
MAY_KNOW = {
    "problems": set(),
    "solvers": {"problems"},
    "results": set(),
    "harness": {"problems", "solvers", "results"},
    "reports": {"results"},
}
COMMAND_LINE = {"cli.py"}


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            found.add((node.module or "").split(".")[0])
    return found


@pytest.mark.parametrize("folder", MAY_KNOW)
def test_no_arrow_runs_back_up_the_road(folder: str) -> None:
    files = sorted((ROOT / folder).rglob("*.py"))
    assert files
    for path in files:
        allowed = MAY_KNOW[folder] | {folder}
        if folder == "harness" and path.name in COMMAND_LINE:
            allowed = allowed | {"reports"}
        assert not (imports(path) & MAY_KNOW.keys()) - allowed, path


def test_every_file_says_what_it_is() -> None:
    silent = [
        path
        for folder in MAY_KNOW
        for path in (ROOT / folder).rglob("*.py")
        if not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert silent == []


def asserts(function: ast.AST) -> bool:
    """Whether a test can fail of its own accord: it asserts, expects an error, or calls a helper that checks."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            return True
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name.endswith(("raises", "fail")) or "assert" in name or "check" in name:
                return True
    return False


def test_every_test_asserts_something() -> None:
    idle = [
        f"{path.name}::{node.name}"
        for path in (ROOT / "tests").rglob("test_*.py")
        if "benchmarks" not in path.parts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test") and not asserts(node)
    ]
    assert idle == []
