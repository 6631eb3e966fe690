"""The battery measures what its closed forms say, on a made-up exact engine and on those that are installed."""

import numpy as np
import pytest

from tools.battery import __main__ as table
from tools.battery import bullet, drake, mujoco, own, rapier
from tools.battery.phenomena import PHENOMENA
from tools.battery.world import Body, Setting

BY_NAME = {one.name: one for one in PHENOMENA}


class Point:
    """The exact motion of one body that slides on a level floor and does not turn, whatever its shape."""

    def __init__(self, setting: Setting, step: float) -> None:
        self.body, self.rate, self.time = setting.bodies[0], setting.friction * 9.81, 0.0

    def run(self, seconds: float) -> None:
        self.time += seconds

    def position(self, body: int) -> np.ndarray:
        if body:
            raise LookupError(body)
        speed = np.linalg.norm(self.body.velocity)
        until = min(self.time, speed / self.rate)
        way = speed * until - self.rate * until**2 / 2
        return np.array(self.body.position) + way * np.array(self.body.velocity) / speed

    def velocity(self, body: int) -> np.ndarray:
        return np.array(self.body.velocity, dtype=float)


@pytest.mark.parametrize("name", ["stopping distance", "direction of sliding"])
def test_closed_forms_on_an_exact_motion(name) -> None:
    one = BY_NAME[name]
    assert one.measure(Point, 0.01) == pytest.approx(one.exact, rel=1e-12)


@pytest.mark.parametrize("name", ["rebound, e = 0.5", "sliding ball that rolls", "1000 kg on 1 kg, sinking"])
def test_own_contacts_are_near_the_closed_forms(name) -> None:
    one = BY_NAME[name]
    assert np.mean(one.measure(own.exact, 0.01)) == pytest.approx(one.exact, abs=1e-7 if "rebound" not in name else 0.15)


def test_own_world_is_tilted_and_turned() -> None:
    """A box on its edge in a groove stays there on level ground, and slides down it with the tilt."""
    corner = Body((0.1, 0.1, 0.1), 1.0, (0, 0, 0.1 * np.sqrt(2)), turn=np.pi / 4)
    world = own.exact(Setting((corner,), 0.2, floors=(np.pi / 4, -np.pi / 4)), 0.01)
    world.run(0.05)
    assert world.position(0) == pytest.approx(corner.position, abs=1e-9)
    world.tilt(np.radians(30))
    world.run(0.05)
    assert world.velocity(0) == pytest.approx([9.81 * (0.5 - 0.2 * np.sqrt(1.5)) * 0.05, 0, 0], abs=1e-6)


def test_page_has_every_phenomenon_and_says_what_is_skipped(monkeypatch) -> None:
    engines = {"exact": ("numpy", Point), "absent": ("no-such-engine", Point)}
    monkeypatch.setattr(table, "ENGINES", engines)
    monkeypatch.setattr(table, "PHENOMENA", (BY_NAME["stopping distance"], BY_NAME["1000 kg on 1 kg, sinking"]))
    made = table.table()
    assert "absent: skipped, it is not installed (`pip install no-such-engine`)." in made
    (row,) = [line for line in made.splitlines() if line.startswith("| stopping distance")]
    assert [abs(float(error)) < 1e-12 for error in row.split("|")[4].split("/")] == [True] * 3
    (row,) = [line for line in made.splitlines() if line.startswith("| 1000 kg")]
    assert "failed: " in row  # the made-up engine has no two bodies


@pytest.mark.parametrize(
    ("engine", "package"),
    [(mujoco.stiff, "mujoco"), (drake.default, "pydrake"), (bullet.stiff, "pybullet"), (rapier.default, "rapier3d")],
)
def test_installed_engines_stop_where_the_closed_form_says(engine, package) -> None:
    pytest.importorskip(package, reason=f"{package} is not installed")
    one = BY_NAME["sliding ball that rolls" if package == "mujoco" else "stopping distance"]
    assert one.measure(engine, 0.001) == pytest.approx(one.exact, rel=0.05)


def test_the_document_has_every_phenomenon() -> None:
    document = table.PAGE.read_text(encoding="utf-8")
    for one in PHENOMENA:
        said = " ".join(str(getattr(one.measure, "func", one.measure).__doc__).split())
        assert f"* **{one.name}**: {said}" in document
        assert f"| {one.name} | {one.formula}" in table.TABLE.search(document)[0]
