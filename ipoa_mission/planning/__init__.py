"""What a good path is, and how to find it."""
