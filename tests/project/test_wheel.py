"""Ordinary installs, from the wheel and from the sdist: in an environment of its own, used from elsewhere, nothing writable but
a scratch folder."""

import json
import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.helpers.paths import ROOT

BUILD = "import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])(sys.argv[2])"
SUBPACKAGES = "problems", "solvers", "harness", "results", "reports"


def build(kind: str, source: Path, out: Path) -> Path:
    """Build "wheel" or "sdist" of a source tree, as a build frontend does, and return the one file made."""
    subprocess.run([sys.executable, "-c", BUILD, f"build_{kind}", str(out)], cwd=source, check=True, capture_output=True)
    (made,) = out.iterdir()
    return made


@pytest.fixture(scope="module", params=["wheel", "sdist"])
def installed(request, tmp_path_factory) -> Path:
    """The environment: the wheel, or that of the sdist, and the dependencies of this one, but not this checkout. Its path has
    spaces."""
    home = tmp_path_factory.mktemp(f"a folder with spaces {request.param}")
    source, environment = home / "source", home / "an environment"
    source.mkdir()
    shutil.copytree(ROOT / "frictionbench", source / "frictionbench")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    if request.param == "sdist":
        shutil.unpack_archive(build("sdist", source, home / "sdists"), home / "unpacked", filter="data")
        shutil.rmtree(source)
        (source,) = (home / "unpacked").iterdir()
    wheel = build("wheel", source, home / "wheels")
    shutil.rmtree(source)
    venv.create(environment, symlinks=True)
    (site,) = environment.glob("lib/python*/site-packages")
    shutil.unpack_archive(wheel, site, "zip")
    others = [entry for entry in sys.path if Path(entry).name == "site-packages"]
    (site / "dependencies.pth").write_text("\n".join(others), encoding="utf-8")
    (environment / "no folder").touch()
    for folder in {path.parent for path in (site / "frictionbench").rglob("*.py")}:
        (folder / "__pycache__").touch()  # where a folder cannot be made: root may write whatever its mode
    return environment


def python(environment: Path, code: str, *arguments: str, **asked: str) -> subprocess.CompletedProcess:
    """Run it from another directory, by a user whose home cannot be made and whose packages cannot be written to.

    The directory is full of packages of the same names as ours.
    """
    elsewhere = environment.parent / "else where"
    for name in SUBPACKAGES:
        (elsewhere / name).mkdir(parents=True, exist_ok=True)
        (elsewhere / name / "__init__.py").write_text("raise ImportError('not ours')", encoding="utf-8")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "XDG_", "NUMBA_CACHE"))}
    command = [environment / "bin" / "python", "-P", "-c", code, *arguments]
    asked |= {"HOME": str(environment / "no folder" / "home"), "TMPDIR": str(elsewhere), "COLUMNS": "200", "PYTHONPATH": ":"}
    return subprocess.run(command, cwd=elsewhere, env=kept | asked, capture_output=True, text=True, check=False, timeout=300)


COMMANDS = """
import json, sys
from frictionbench.commands.cli import main
for arguments in json.loads(sys.argv[1]):
    sys.argv[1:] = arguments
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, (arguments, ended.code)
    print(end="\\0", flush=True)
"""


def frictionbench(environment: Path, *commands: list[str]) -> list[str]:
    """What commands print, one after the other in one Python; nothing is compiled, which would take a minute."""
    done = python(environment, COMMANDS, json.dumps(commands), NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\0")[:-1]


def test_one_top_level_package(installed) -> None:
    (site,) = installed.glob("lib/python*/site-packages")
    ours = {path.name for path in site.iterdir()} - {"dependencies.pth"}
    assert {name for name in ours if not name.endswith(".dist-info")} == {"frictionbench"}
    (listed,) = site.glob("frictionbench-*.dist-info/top_level.txt")
    assert listed.read_text(encoding="utf-8").split() == ["frictionbench"]
    assert (site / "frictionbench" / "py.typed").is_file()


def test_install_works_without_home(installed) -> None:
    baseline = next(installed.glob("lib/python*/site-packages/frictionbench/results/baselines/smoke.tsv"))
    assert "lemke\tsolve\t" in baseline.read_text(encoding="utf-8")
    results, mine = installed.parent / "results of mine", installed.parent / "baselines" / "mine.tsv"
    commands = (
        (["--help"], "Compare solvers for the friction LCPs"),
        (["list", "solvers"], "nsgs"),
        (["run", "smoke", "--scene", "stack", "--solver", "lemke", "--jobs", "1", "--out", str(results)], "results of mine"),
        (["accept", str(results), str(mine)], "accepted: "),
        (["compare", str(mine), str(results)], "## worse 0"),
        (["report", str(results)], "report: "),
        (["solve", "stack", "--solver", "lemke"], "use lemke: solved"),
    )
    printed = frictionbench(installed, *(arguments for arguments, _ in commands))
    for (arguments, told), text in zip(commands, printed, strict=True):
        assert told in text, arguments
    assert next(results.glob("*.html")).stat().st_size > 5 * 10**4


def test_kernel_cache_in_temporary_folder(installed) -> None:
    done = python(installed, "import frictionbench as fb; print(len(fb.scene('stack').problem().friction))")
    assert done.returncode == 0, done.stderr
    assert list((installed.parent / "else where").rglob("*.nbi"))
    assert not [path for path in installed.rglob("__pycache__/*") if "site-packages/frictionbench" in str(path)]
