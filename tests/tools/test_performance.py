"""The page on performance: rates of a run of batches, large problems with what was not run, and families of hard ones."""

from pathlib import Path

import frictionbench as fb
from tests.helpers.made_results import batch_row, write_folder
from tools import performance
from tools.hard_families import Family, section


def test_rates_stand_in_a_table_for_each_batch(tmp_path: Path) -> None:
    rows = [
        batch_row("lemke", "calls"),
        batch_row("lemke", "packed"),
        batch_row("osqp", "calls", verified=0.5, verdict="relaxed"),
    ]
    told = performance.rates(write_folder(tmp_path, [], batches=rows))
    assert "### 4 contacts in the plane: stack[blocks=2]" in told
    assert "| lemke | packed | cold | 1,000 | 2 | 0.50 | 0.50 | 0.50 |" in told
    assert "| osqp | calls | cold | 50 % verified | – |" in told
    assert max(map(len, told.splitlines())) <= 128


def _cells(family: Family) -> list[str]:
    return [cell.strip() for cell in section((family,)).splitlines()[-1].split("|")[1:-1]]


def test_only_verified_answers_count_as_solved() -> None:
    def make(seed):
        return fb.instance("random_bodies", seed=seed, contacts=10 + seed)

    title, contacts, solved, worst, *_ = _cells(Family("bodies", make, 3))
    assert (title, contacts, solved, worst) == ("bodies", "10–12", "3 of 3", "")
    _, _, solved, worst, *_ = _cells(Family("bodies", make, 3, "relaxation_ip"))
    assert solved == "0 of 3"
    assert float(worst) > 1e-3  # contacts slide, which the relaxation answers with another motion
