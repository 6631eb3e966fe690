"""Steps of engines as friction problems, one file an engine; an engine is imported when its function is called."""
