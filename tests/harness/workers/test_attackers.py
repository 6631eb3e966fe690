"""A solver that attacks the process it runs in falsifies at most the measured values of its own rows."""

from itertools import product
from typing import Any

import pandas as pd
import pytest

from frictionbench.harness.workers.inputs import load_plugins
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT
from tests.helpers.plugin import write
from tests.helpers.runs import run_of

pytestmark = pytest.mark.slow  # the quick tests run no attacks within a worker

FACTS = ["solver", "variant", "family", "model", "scene", "parameters", "problem", "contacts", "tol", "time_limit", "start"]


def test_attacks_within_a_worker(tmp_path) -> None:
    """Patched verifiers, frames, the garbage collector, the pipe of replies, and subclasses of Answer and ndarray."""
    good = ("lemke", "nsgs")
    specs = [str(ROOT / "tests" / "helpers" / "attackers.py"), *good]
    variants, plugins = load_plugins(specs)
    given: dict[str, Any] = {"tolerances": (1e-6, 1e-8), "time_limit": 1.0}
    alone, together = (run_of(tmp_path / f"{len(named)}", *named, **given).set_index("key") for named in (good, specs))
    kept = [*FACTS, "verdict", "residual", "work", "claimed"]
    pd.testing.assert_frame_equal(together.loc[alone.index, kept], alone[kept], check_dtype=False)
    assert sorted(zip(together["solver"], together["tol"], strict=True)) == sorted(product(variants, given["tolerances"]))
    described = {variant: facts for plugin in plugins for variant, facts in plugin.solvers.items()}
    theirs = together[~together.index.isin(alone.index)]
    assert (theirs["problem"] == alone["problem"].iloc[0]).all()
    assert (theirs["time_limit"] == 1.0).all()
    assert {row["solver"]: row["family"] for row in theirs.to_dict("records")} == {v: f["family"] for v, f in described.items()}


FORGED = """
import json, os
for number in map(int, os.listdir("/proc/self/fd")):
    try:
        os.set_blocking(number, False)
        os.write(number, json.dumps({"value": VALUE}).encode() + b"\\n")
    except OSError:
        continue
os._exit(0)
"""

MALFORMED = ("None", "1", "[]", "{}", "{'source': 'x', 'content': 'y', 'solvers': {}}", "{'solvers': {'lemke': {}}}")
NESTED = "__import__('functools').reduce(lambda inner, _: [inner], range(700), 1)"


@pytest.mark.parametrize("value", [*MALFORMED, NESTED])
def test_forged_descriptions_are_refused(tmp_path, value) -> None:
    plugin = write(tmp_path / "guest.py", first=FORGED.replace("VALUE", value))
    done = frictionbench("solve", "stack[blocks=1]", "--solver", str(plugin))
    assert done.returncode == 2
    told = "its worker returned a malformed description" if value in MALFORMED else "the worker's reply is nested too deeply"
    assert f"cannot be imported ({told})" in done.stderr
    assert len(done.stderr.splitlines()) == 1
