"""Steps of engines as friction problems, one file per engine; an engine is imported when its function is called."""
