"""Scenes, one file per scene or family of scenes, registered by a decorator (problems.catalogue).

    scene("stack", blocks=10, friction=0.5)        scene("example_2")

The talk's numbered examples (Anitescu 1999, page 30) are scenes with the talk's friction and restitution.
"""

from frictionbench.problems.catalogue import scene, scenes

__all__ = ["scene", "scenes"]
