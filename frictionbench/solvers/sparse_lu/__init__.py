"""A sparse LU factorisation for matrices assembled from small dense blocks."""
