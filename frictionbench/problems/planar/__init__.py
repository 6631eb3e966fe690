"""Planar geometry: bodies, collision, joints."""
