"""What uses the package and is not part of it: published results, generators of documents."""
