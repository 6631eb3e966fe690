"""Scenes, one file per scene or family of scenes, registered by a decorator (problems.catalogue).

The talk's numbered examples (Anitescu 1999, page 30) are scenes with the talk's friction and restitution.
"""
