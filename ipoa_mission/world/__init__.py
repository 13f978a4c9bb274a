"""Obstacles, terrain, bounds, and exact distances."""
