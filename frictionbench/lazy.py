"""Names that are imported when they are first used, so that `import frictionbench` alone loads neither numpy nor numba.

The package's __init__ lists them once, as imports that only a type checker executes:

    if TYPE_CHECKING:
        from frictionbench.problems.catalogue import scene as scene

    __getattr__ = importer(__name__, __file__)
"""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def importer(package: str, file: str) -> Callable[[str], Any]:
    """Return the __getattr__ of a package. file: its __init__, which says from which module each name is imported."""
    listed = (node for node in ast.walk(ast.parse(Path(file).read_text("utf-8"))) if isinstance(node, ast.ImportFrom))
    modules = {each.asname or each.name: (node.module or "", each.name) for node in listed for each in node.names}

    def get(name: str) -> Any:
        module, attribute = modules.get(name, ("", ""))
        if module.partition(".")[0] != "frictionbench":
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = None if module == package else getattr(import_module(module), attribute, None)
        value = import_module(f"{module}.{attribute}") if value is None else value
        setattr(sys.modules[package], name, value)
        return value

    return get
