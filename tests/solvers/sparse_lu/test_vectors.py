"""The file of vector instructions and the cache of compiled kernels."""

import shutil

from frictionbench.problems.compiled import state
from tests.helpers.paths import ROOT


def test_vector_instructions_change_cache(tmp_path) -> None:
    copy = tmp_path / "solvers" / "sparse_lu" / "vectors.py"
    copy.parent.mkdir(parents=True)
    shutil.copy(ROOT / "solvers" / "sparse_lu" / "vectors.py", copy)
    before = state(tmp_path)
    copy.write_text(copy.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert state(tmp_path) != before
