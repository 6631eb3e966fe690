"""Figures, the HTML page, and figures and tables for papers, made from a results folder without running anything again."""
