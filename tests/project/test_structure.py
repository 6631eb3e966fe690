"""The code follows the road of docs/architecture.md, which says what each folder may import; there are no import cycles."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.helpers.paths import ROOT

PACKAGE = ROOT / "frictionbench"
ROWS = re.findall(r"^\| `(\w+)/` \| ([^|]+) \|", (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"), re.MULTILINE)
MAY_IMPORT = {folder: set(re.findall(r"`([\w.]+)`", allowed)) for folder, allowed in ROWS}  # as the page states
OUTSIDE = ("studies", "tools")  # they use the package through FACES, and the files of three folders
FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(path for top in ("frictionbench", *OUTSIDE) for path in (ROOT / top).rglob("*.py"))
}
FACES = {"frictionbench", "frictionbench.problems", "frictionbench.solvers"}


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path) -> Iterator[tuple[str, str | None]]:
    """Each import of a file, within functions as well, as (module, name of it)."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                yield (submodule, None) if submodule in FILES else (str(node.module), alias.name)


def ours(module: str) -> set[tuple[str, str | None]]:
    """The imports of a module from this project, with the names of the package shortened to those of its folders."""
    return {(target, name) for target, name in imports(FILES[module]) if target.split(".")[0] in ("frictionbench", *OUTSIDE)}


def folder_of(module: str) -> str:
    """The folder of a module at the top of the road: problems, solvers, ..., studies, tools; empty for the public face."""
    first, *rest = module.split(".")
    return first if first in OUTSIDE else rest[0] if rest and rest[0] in MAY_IMPORT else ""


def allowed(target: str, known: set[str]) -> bool:
    short = target.removeprefix("frictionbench.")
    return any(short == name or short.startswith(name + ".") for name in known)


def test_the_page_lists_every_folder() -> None:
    there = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert set(MAY_IMPORT) - set(OUTSIDE) == there
    for name, known in MAY_IMPORT.items():
        earlier = list(MAY_IMPORT)[: list(MAY_IMPORT).index(name)]
        assert {other.split(".")[0] for other in known} <= {*earlier, "frictionbench"}, f"{name} imports from above it"


@pytest.mark.parametrize("folder", [name for name in MAY_IMPORT if name not in OUTSIDE])
def test_folders_import_only_those_below(folder: str) -> None:
    modules = [module for module in FILES if folder_of(module) == folder]
    assert modules
    known = MAY_IMPORT[folder] | {folder, "lazy", "regular"}  # which all folders use
    forbidden = [
        f"{module} imports {target}"
        for module in modules
        for target, _ in sorted(ours(module), key=str)
        if not allowed(target, known)
    ]
    assert forbidden == []


def test_studies_and_tools_use_the_public_face() -> None:
    forbidden = [
        f"{module} imports {target}"
        for module in FILES
        if (top := folder_of(module)) in OUTSIDE
        for target, _ in sorted(ours(module), key=str)
        if target not in FACES
        and not re.match(r"frictionbench\.(results|harness|reports)\.", target)
        and target.split(".")[0] not in (top, "tools" if top == "studies" else top)
    ]
    assert forbidden == []


def cycle(graph: dict[str, set[str]]) -> list[str]:
    """One import cycle, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as found:
        return list(found.args[1])
    return []


def graph_of(files: dict[str, Path]) -> dict[str, set[str]]:
    """What each module imports, at any place of it. The __init__ of a folder imports what lies in it, and is left out."""
    return {
        module: {target for target, _ in imports(path) if target in files and target != module}
        for module, path in files.items()
        if path.name != "__init__.py"
    }


def test_no_import_cycles() -> None:
    assert cycle(graph_of(FILES)) == []


def test_private_names_are_not_imported() -> None:
    imported = [
        f"{module} imports {name} from {target}"
        for module in FILES
        for target, name in ours(module)
        if name and name.startswith("_") and not name.startswith("__")
    ]
    assert imported == []


def test_no_duration_is_measured_by_the_date() -> None:
    """time.time jumps when the machine's date is set; limits, times and waits use clocks that do not."""
    found = [
        module
        for module, path in FILES.items()
        if ("time", "time") in imports(path)
        or any(ast.unparse(node) == "time.time" for node in ast.walk(tree(path)) if isinstance(node, ast.Attribute))
    ]
    assert found == []


def test_module_docstrings() -> None:
    assert [module for module, path in FILES.items() if not ast.get_docstring(tree(path))] == []
