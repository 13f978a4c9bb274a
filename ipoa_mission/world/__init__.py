"""Obstacles, terrain and bounds, and exact distances to them."""
