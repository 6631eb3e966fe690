"""An ordinary install: the wheel in an environment of its own, used from elsewhere, nothing writable but a scratch folder."""

import json
import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BUILD = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
CODE = "problems", "solvers", "harness", "results", "reports"


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """The environment: the wheel, and the dependencies of this one, but not this checkout. Its path has spaces."""
    pytest.importorskip("setuptools", minversion="77")
    home = tmp_path_factory.mktemp("a folder with spaces")
    source, wheels, environment = home / "source", home / "wheels", home / "an environment"
    source.mkdir()
    for name in (*CODE, "frictionbench.py", "pyproject.toml", "README.md", "LICENSE"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, source / name)
    subprocess.run([sys.executable, "-c", BUILD, str(wheels)], cwd=source, check=True, capture_output=True)
    shutil.rmtree(source)
    venv.create(environment, symlinks=True)
    (site,) = environment.glob("lib/python*/site-packages")
    (wheel,) = wheels.iterdir()
    shutil.unpack_archive(wheel, site, "zip")
    others = [entry for entry in sys.path if Path(entry).name == "site-packages"]
    (site / "dependencies.pth").write_text("\n".join(others), encoding="utf-8")
    (environment / "no folder").touch()
    for folder in {path.parent for name in CODE for path in (site / name).rglob("*.py")}:
        (folder / "__pycache__").touch()  # where a folder cannot be made: root may write whatever its mode
    return environment


def python(environment: Path, code: str, *arguments: str, **asked: str) -> subprocess.CompletedProcess:
    """Run it from another directory, by a user whose home cannot be made and whose packages cannot be written to."""
    elsewhere = environment.parent / "else where"
    elsewhere.mkdir(exist_ok=True)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "XDG_", "NUMBA_CACHE"))}
    command = [environment / "bin" / "python", "-P", "-c", code, *arguments]
    asked |= {"HOME": str(environment / "no folder" / "home"), "TMPDIR": str(elsewhere), "COLUMNS": "200"}
    return subprocess.run(command, cwd=elsewhere, env=kept | asked, capture_output=True, text=True, check=False, timeout=300)


COMMANDS = """
import json, sys, frictionbench
for arguments in json.loads(sys.argv[1]):
    sys.argv[1:] = arguments
    try:
        frictionbench.main()
    except SystemExit as ended:
        assert not ended.code, (arguments, ended.code)
    print(end="\\0", flush=True)
"""


def frictionbench(environment: Path, *commands: list[str]) -> list[str]:
    """What commands print, one after the other in one Python; nothing is compiled, which would take a minute."""
    done = python(environment, COMMANDS, json.dumps(commands), NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\0")[:-1]


def test_a_wheel_works_from_elsewhere_without_a_home(installed) -> None:
    baseline = next(installed.glob("lib/python*/site-packages/results/baselines/smoke.tsv"))
    assert "lemke\tsolve\t" in baseline.read_text(encoding="utf-8")
    results, mine = installed.parent / "results of mine", installed.parent / "baselines" / "mine.tsv"
    commands = (
        (["--help"], "Compare solvers for the friction LCPs"),
        (["list", "solvers"], "nsgs"),
        (["run", "smoke", "--scene", "stack", "--solver", "lemke", "--jobs", "1", "--out", str(results)], "results of mine"),
        (["accept", str(results), str(mine)], "accepted: "),
        (["compare", str(mine), str(results)], "## worse 0"),
        (["report", str(results)], "report: "),
        (["solve", "stack[blocks=2]", "--solver", "nsgs"], "use nsgs: solved"),
    )
    printed = frictionbench(installed, *(arguments for arguments, _ in commands))
    for (arguments, told), text in zip(commands, printed, strict=True):
        assert told in text, arguments
    assert next(results.glob("*.html")).stat().st_size > 5 * 10**4


def test_kernels_are_kept_in_the_temporary_folder_where_nothing_else_can_be_written(installed) -> None:
    done = python(installed, "import frictionbench as fb; print(len(fb.scene('stack').problem().friction))")
    assert done.returncode == 0, done.stderr
    assert list((installed.parent / "else where").rglob("*.nbi"))
    assert not [path for path in installed.rglob("__pycache__/*") if "site-packages/problems" in str(path)]
