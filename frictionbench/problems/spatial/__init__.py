"""Spatial bodies: rotations, boxes and spheres, and the contacts between them."""
