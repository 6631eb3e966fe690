"""A sparse LU factorisation for matrices put together from small dense blocks."""
