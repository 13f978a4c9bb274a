"""How a mission is judged before it flies."""
