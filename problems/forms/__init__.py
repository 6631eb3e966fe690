"""The forms a friction problem is written in: Delassus matrix, LCP, convex relaxation."""
