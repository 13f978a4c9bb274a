"""Plan the lines of a survey and its flights."""
