"""What `hybrid` knows of its members beforehand: which of the first two is faster on a problem, and what each may bring."""
