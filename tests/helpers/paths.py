"""Paths inside the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HELPERS = ROOT / "tests" / "helpers"
DATA = ROOT / "tests" / "data"  # regression problems
BAD_SOLVERS = HELPERS / "bad_solvers.py"
