"""Adapters of outside libraries, one file each."""
