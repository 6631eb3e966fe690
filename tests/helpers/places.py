"""Where things lie in the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HELPERS = ROOT / "tests" / "helpers"
DATA = ROOT / "tests" / "data"  # small problems on which a method once failed
BAD_SOLVERS = HELPERS / "bad_solvers.py"
