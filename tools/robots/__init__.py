"""Robots: models of other packages, steps recorded from them, and solvers in closed loop with MuJoCo.

    python -m tools.robots.record     records and selects the steps of the suite `robots`, and answers them
    python -m tools.robots.loop       solvers in closed loop, compared with MuJoCo's own step

Needs mujoco, dm_control and gymnasium-robotics. The last two can be installed with `pip install --no-deps`, since their files
are read but not imported.
"""
