"""Refuses to build a package without its folders, which setuptools would do without a message."""

from pathlib import Path

from setuptools import setup

FOLDERS = "problems", "solvers", "results", "harness", "reports", "commands"
missing = [name for name in FOLDERS if not (Path(__file__).parent / "frictionbench" / name / "__init__.py").is_file()]
if missing:
    raise SystemExit(f"frictionbench/{missing[0]} is missing from this source tree: the package would be installed without it")
setup()
