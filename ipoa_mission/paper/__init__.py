"""Whether the paper is right."""
