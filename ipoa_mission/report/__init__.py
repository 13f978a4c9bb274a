"""How to show it."""
