"""Scenes that a user names are built in a worker first, behind its limits: a million blocks take a minute and gigabytes."""

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from frictionbench.harness.cells import worker
from frictionbench.harness.plans.plan import MEMORY_LIMIT
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Task
from frictionbench.problems import InputError
from frictionbench.results.conventions import scene_title

BUILD_SECONDS = 60.0  # seconds to build a scene and its first problem: the largest of the suites takes one


def require_buildable(chosen: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Build each of these scenes and instances, by name and parameters, in a worker.

    Errors: InputError naming the parameter, or the scene where it takes too much memory or time.
    """
    tasks = [Task(name, worker.run_scene, (name, parameters, BUILD_SECONDS), BUILD_SECONDS) for name, parameters in chosen]
    if not tasks:
        return
    with tempfile.TemporaryDirectory() as scratch, Pool(Path(scratch), 1, (), MEMORY_LIMIT) as pool:
        for outcome in pool.run(tasks):
            name, parameters, _ = outcome.task.arguments
            if outcome.failure:
                raise InputError(f"scene: {scene_title(name, json.dumps(parameters))} cannot be made ({outcome.reason})")
            if reason := outcome.value.get("refused"):
                raise InputError(reason)
