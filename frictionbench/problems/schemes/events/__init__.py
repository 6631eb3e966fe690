"""Smooth motion between events: forces and accelerations, modes of contact, and the path up to the next event."""
