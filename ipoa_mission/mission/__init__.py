"""Mission files and the wire: what a mission is outside the package."""
