"""What a problem is like, whoever solves it: labels, stability, the census of its solutions."""
