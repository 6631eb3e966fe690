"""The battery measures what its closed forms say, on our own contacts and on the engines that are installed."""

import numpy as np
import pytest

from tools.battery import __main__ as table, bullet, drake, mujoco, own, rapier
from tools.battery.phenomena import PHENOMENA
from tools.battery.world import Body, Setting, Unsupported

BY_NAME = {one.name: one for one in PHENOMENA}


# How near our own contacts come with steps of 10 ms, in units of the phenomenon.
NEAR = {"stopping distance": 0.011, "rebound, e = 0.5": 0.15}
NEAR |= dict.fromkeys(("direction of sliding", "sliding ball that rolls", "1000 kg on 1 kg, sinking"), 1e-7)


@pytest.mark.parametrize("name", NEAR)
def test_own_contacts_are_near_the_closed_forms(name) -> None:
    one = BY_NAME[name]
    assert np.mean(one.measure(own.Exact, 0.01)) == pytest.approx(one.exact, abs=NEAR[name])


def test_own_world_is_tilted_and_turned() -> None:
    """A box on its edge in a groove stays there on level ground, and slides down it with the tilt."""
    corner = Body((0.1, 0.1, 0.1), 1.0, (0, 0, 0.1 * np.sqrt(2)), turn=np.pi / 4)
    world = own.Exact(Setting((corner,), 0.2, floors=(np.pi / 4, -np.pi / 4)), 0.01)
    world.run(0.05)
    assert world.position(0) == pytest.approx(corner.position, abs=1e-9)
    world.tilt(np.radians(30))
    world.run(0.05)
    assert world.velocity(0) == pytest.approx([9.81 * (0.5 - 0.2 * np.sqrt(1.5)) * 0.05, 0, 0], abs=1e-6)


def test_page_says_what_is_skipped_and_what_failed(monkeypatch) -> None:
    def rigid(setting: Setting, step: float) -> None:
        if setting.restitution:
            raise Unsupported("no restitution")

    monkeypatch.setattr(table, "ENGINES", {"rigid": ("numpy", rigid), "absent": ("no-such-engine", rigid)})
    monkeypatch.setattr(table, "PHENOMENA", (BY_NAME["rebound, e = 0.5"], BY_NAME["1000 kg on 1 kg, sinking"]))
    made = table.sections()
    assert "absent: skipped, it is not installed (`pip install no-such-engine`)." in made
    rebound, sinking = [line for line in made.splitlines() if line.startswith("| rigid")]
    assert rebound == "| rigid | – | – | – | – | – |"
    assert "failed: " in sinking


def test_orders_are_slopes_over_all_steps() -> None:
    assert table.order_of(["8e-3 ± 1e-3", "4e-3", "1e-3", "2.5e-4"]) == "1.7 ± 0.1 (1.0, 2.0)"
    for last in ("-1e-3", "1e-3 ± 3e-3", "–", "failed: ValueError"):
        assert table.order_of(["8e-3", "4e-3", "2e-3", last]) == "–"


@pytest.mark.parametrize(
    ("engine", "package"),
    [
        (mujoco.stiff, "mujoco"),
        (drake.Drake, "pydrake"),
        (drake.cenic, "pydrake"),
        (bullet.stiff, "pybullet"),
        (rapier.Rapier, "rapier3d"),
    ],
)
def test_installed_engines_stop_where_the_closed_form_says(engine, package) -> None:
    pytest.importorskip(package, reason=f"{package} is not installed")
    one = BY_NAME["sliding ball that rolls" if package == "mujoco" else "stopping distance"]
    assert np.array(one.measure(engine, 0.001)) == pytest.approx(one.exact, rel=0.05)


def test_the_document_has_every_phenomenon() -> None:
    document = table.PAGE.read_text(encoding="utf-8")
    for one in PHENOMENA:
        assert table.section(one, {}) in document  # the words and the headings of the table
