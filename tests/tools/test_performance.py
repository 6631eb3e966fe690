"""The page on performance: rates of a run of batches."""

from pathlib import Path

from tests.helpers.made_results import batch_row, write_folder
from tools import performance


def test_rates_stand_in_a_table_for_each_batch(tmp_path: Path) -> None:
    rows = [
        batch_row("lemke", "calls"),
        batch_row("lemke", "packed"),
        batch_row("osqp", "calls", verified=0.5, verdict="relaxed"),
    ]
    told = performance.rates(write_folder(tmp_path, [], batches=rows))
    assert "### 4 contacts in the plane: stack[blocks=2]" in told
    assert "| lemke | packed | cold | 1,000 | 2 |" in told
    assert "| osqp | calls | cold | 50 % verified | – |" in told
    assert max(map(len, told.splitlines())) <= 128
