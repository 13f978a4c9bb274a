"""What is held to be true of the package, and what the tests share."""
