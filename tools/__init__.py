"""Programs that use the package and are not part of it: generators of documents, sets of problems and published results."""
