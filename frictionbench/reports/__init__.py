"""Figures, the HTML page, paper figures and tables: made from a results folder, without running anything again."""
