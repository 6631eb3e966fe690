"""Capture a step of a running engine as a problem, with the impulses that the engine used.

    mujoco(model, data)      before mujoco.mj_step(model, data)
    drake(plant, context)    before simulator.AdvanceTo(...); the context is the diagram's

One line in the engine's loop writes a folder of steps, which `frictionbench judge FOLDER` judges:

>>> from frictionbench import capture
>>> capture.mujoco(model, data).save("steps")  # doctest: +SKIP

Other engines write their arrays with `frictionbench.save(problem, path, impulse=...)`: docs/engines.md.
"""

from frictionbench.problems.capture.drake import drake
from frictionbench.problems.capture.mujoco import mujoco

__all__ = ["drake", "mujoco"]
