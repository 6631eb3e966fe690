"""The forms of a friction problem: Delassus matrix, LCP, convex relaxation."""
