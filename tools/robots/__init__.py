"""Robots: models of other packages, steps recorded of them, and solvers in the loop of MuJoCo.

    python -m tools.robots.record     records and selects the steps of the suite `robots`, and answers them
    python -m tools.robots.loop       solvers in closed loop beside MuJoCo's own step

Needs mujoco, dm_control and gymnasium-robotics, the last two installed with `pip install --no-deps`: their files are read, and
nothing of them is imported.
"""
