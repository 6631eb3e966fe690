"""Problems of few contacts in space, whose Delassus matrix is formed dense."""
