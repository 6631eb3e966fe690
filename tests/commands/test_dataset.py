"""The data set holds each problem in both formats with a verified answer, and its checksums hold."""

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from frictionbench.commands.dataset import dataset
from frictionbench.problems.recorded import read_recording
from frictionbench.problems.residual import residual


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("data") / "set"
    dataset(["smoke"], ["stack[blocks=2,push=1]", "rod_chain"], out, lambda line: None)
    return out


def test_both_formats_hold_the_problem_and_its_answer(folder: Path) -> None:
    table = pd.read_csv(folder / "problems.tsv", sep="\t")
    assert set(table["scene"]) == {"stack", "rod_chain"}
    for row in table.to_dict("records"):
        problem, _ = read_recording(folder / row["npz"])
        assert problem.hash == row["problem"]
        with np.load(folder / row["answer"]) as answer:
            assert residual(problem, answer["impulse"]) == answer["residual"] <= 1e-8
            impulse = answer["impulse"]
        same, _ = read_recording(folder / row["fclib"])
        assert residual(same, impulse) <= 1e-8
        with h5py.File(folder / row["fclib"]) as file:
            assert ("solution" in file) == (problem.joints.shape[0] == 0)
            if "solution" in file:
                np.testing.assert_array_equal(file["solution/r"][:], impulse.ravel())


def test_card_and_checksums(folder: Path) -> None:
    card = (folder / "README.md").read_text(encoding="utf-8")
    assert "CC-BY-4.0" in card
    assert "{" not in card
    assert "| `stack` | 6 | 2 | 4 to 4 | 0 |" in card
    subprocess.run(["sha256sum", "--check", "--quiet", "SHA256SUMS"], cwd=folder, check=True)
