"""Imports follow the declared layers without cycles, every module has a docstring, and every test asserts something."""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.helpers.paths import ROOT

LAYERS = ("problems", "solvers", "results", "harness", "reports", "commands")
PACKAGE = ROOT / "frictionbench"
_MECHANISMS = ("harness.machine", "harness.process", "harness.deadline")
# What each layer (a folder, a subpackage or a module, by its dotted name) may import from this project besides its own modules.
MAY_IMPORT = {
    "problems.compiled": set(),
    "problems.rows": {"problems.compiled"},
    "problems.check": {"problems.compiled", "problems.rows"},
    "problems.display": {"problems.rows"},
    "problems.sizes": {"problems.check", "problems.rows"},
    "problems.forms": {"problems.check", "problems.compiled", "problems.display", "problems.rows"},
    "problems.operators": {"problems.check", "problems.forms", "problems.rows"},
    "problems.planar": {"problems.check", "problems.compiled", "problems.rows"},
    "problems.spatial": {"problems.check", "problems.rows", "problems.planar.collision"},
    "problems.analysis": {"problems.check", "problems.forms", "problems.friction", "problems.reduce", "problems.residual"},
    "problems.recorded": {"problems.check", "problems.forms", "problems.friction", "problems.sizes"},
    "problems.capture": {"problems.check", "problems.friction", "problems.recorded.engine_step"},
    "problems": {"problems"},
    "solvers.needs": set(),
    "solvers.balanced": {"problems"},
    "solvers.clock": {"problems.compiled"},
    "solvers.interface": {"problems", "solvers.needs", "solvers.balanced", "solvers.clock"},
    "solvers.loops": {"problems", "solvers.balanced", "solvers.interface"},
    "solvers.pivots": {"problems", "solvers.interface", "solvers.clock", "solvers.sparse_lu"},
    "solvers.sweeps": {"problems", "solvers.interface", "solvers.clock"},
    "solvers.sparse_lu": {"problems.check", "problems.compiled"},
    "solvers.interior": {"problems", "solvers.interface", "solvers.clock", "solvers.loops", "solvers.sparse_lu"},
    "solvers.outside.children": set(),
    "solvers.outside": {"problems", "solvers.interface", "solvers.pivots.dense_lcp"},
    "solvers": {"problems", "solvers"},
    "results": set(),
    "harness.plans": {"problems", "solvers", "results"},
    "harness.cells": {"problems", "solvers", "results", "harness.plans", "harness.verify", *_MECHANISMS},
    "harness.workers": {"problems", "solvers", "results", "harness.plans", "harness.cells", *_MECHANISMS},
    "harness.studies": {"problems", "solvers", "results", "harness.plans", "harness.verify", "harness.machine"},
    "harness.contract": {
        *("problems", "solvers", "results", "harness.cells", "harness.plans", "harness.verify", "harness.workers"),
    },
    "harness.battery": {"problems", "solvers"},
    "harness": {"problems", "solvers", "results", "harness"},
    "reports": {"results"},
    "commands": {"problems", "solvers", "results", "harness", "reports"},
}
PUBLIC_MODULES = sorted((ROOT / "frictionbench").glob("*.py"))  # they may import all layers, and no layer imports them
FILES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): path
    for folder in LAYERS
    for path in sorted((PACKAGE / folder).rglob("*.py"))
}


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path: Path, *, at_once: bool = False) -> Iterator[tuple[str, str | None]]:
    """Yield each import of a file as (module, name); at_once: only those at module level."""
    for node in tree(path).body if at_once else ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from ((alias.name.removeprefix("frictionbench."), None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            for alias in node.names:
                home = str(node.module).removeprefix("frictionbench.")
                yield (f"{home}.{alias.name}", None) if f"{home}.{alias.name}" in FILES else (home, alias.name)


def within(module: str, layer: str) -> bool:
    return module == layer or module.startswith(layer + ".")


def layer_of(module: str) -> str:
    return max((layer for layer in MAY_IMPORT if within(module, layer)), key=len)


@pytest.mark.parametrize("module", FILES)
def test_import_directions(module: str) -> None:
    layer = layer_of(module)
    ours = {target for target, _ in imports(FILES[module]) if target.split(".")[0] in LAYERS}
    forbidden = {
        target for target in ours if not within(target, layer) and not any(within(target, known) for known in MAY_IMPORT[layer])
    }
    assert not forbidden, f"{module}, of {layer}, may not import {forbidden}"


@pytest.mark.parametrize("module", FILES)
def test_public_modules_are_not_imported(module: str) -> None:
    names = {"frictionbench", *(path.stem for path in PUBLIC_MODULES)}
    assert {target for target, _ in imports(FILES[module]) if target in names} == set()


def test_public_modules_import_public_names_only() -> None:
    imported = [(path.name, name) for path in PUBLIC_MODULES for _, name in imports(path) if str(name).startswith("_")]
    assert imported == []


def test_no_import_cycles() -> None:
    # The __init__ of a folder imports what lies in it; importing a module of the folder does not count as importing the rest.
    known = {
        module: {target for target, _ in imports(path, at_once=True) if target in FILES and target != module}
        for module, path in FILES.items()
        if path.name != "__init__.py"
    }
    try:
        TopologicalSorter(known).prepare()
    except CycleError as cycle:
        pytest.fail(" -> ".join(cycle.args[1]))


def test_private_names_are_not_imported() -> None:
    imported = [
        f"{module} imports {name} from {target}"
        for module, path in FILES.items()
        for target, name in imports(path)
        if name and name.startswith("_") and not name.startswith("__") and target.split(".")[0] in LAYERS
    ]
    assert imported == []


@pytest.mark.parametrize("module", FILES)
def test_no_duration_is_measured_by_the_date(module: str) -> None:
    """time.time jumps when the machine's date is set; limits, times and waits use clocks that do not."""
    assert ("time", "time") not in imports(FILES[module])
    assert not any(
        ast.unparse(node) == "time.time" for node in ast.walk(tree(FILES[module])) if isinstance(node, ast.Attribute)
    )


@pytest.mark.parametrize("module", FILES)
def test_module_docstrings(module: str) -> None:
    assert ast.get_docstring(tree(FILES[module]))


def test_solver_modules_register_solvers() -> None:
    others = ("__init__", "balanced", "clock", "executable", "interface", "loops", "many", "needs", "plugins")
    methods = [path.stem for path in (ROOT / "solvers").glob("*.py") if path.stem not in others]
    decorated = [
        path
        for path in methods
        if any(
            isinstance(node, ast.ClassDef) and any("solver(" in ast.unparse(mark) for mark in node.decorator_list)
            for node in tree(ROOT / "solvers" / f"{path}.py").body
        )
    ]
    assert methods == decorated
    assert len(methods) <= 25


@cache
def checkers(module: ast.Module) -> set[str]:
    """The functions of a test module that assert or expect an error, directly or through other functions of the module."""
    functions = {node.name: node for node in ast.walk(module) if isinstance(node, ast.FunctionDef)}
    found: set[str] = set()
    while more := {name for name, node in functions.items() if name not in found and asserts(node, found)}:
        found |= more
    return found


def asserts(function: ast.AST, helpers: set[str]) -> bool:
    """Whether a function asserts, expects an error, or calls a helper that does."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            return True
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name in ("pytest.raises", "pytest.fail", "pytest.warns") or name in helpers:
                return True
            if name.startswith(("np.testing.assert_", "pd.testing.assert_")):
                return True
    return False


def test_every_test_asserts_something() -> None:
    shared = {name for path in (ROOT / "tests" / "helpers").glob("*.py") for name in checkers(tree(path))}
    without_assertion = [
        f"{path.name}::{node.name}"
        for path in (ROOT / "tests").rglob("test_*.py")
        if "benchmarks" not in path.parts
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test")
        if not asserts(node, (checkers(tree(path)) | shared) - {node.name})
    ]
    assert without_assertion == []


@pytest.mark.parametrize(
    ("text", "can_fail"),
    [
        ("def test(): assert f()", True),
        ("def test(): check_run(f())", False),
        ("def test():\n with pytest.raises(ValueError): f()", True),
        ("def test(): checked = f()", False),
    ],
)
def test_asserts(text: str, can_fail: bool) -> None:
    assert asserts(ast.parse(text), set()) is can_fail
