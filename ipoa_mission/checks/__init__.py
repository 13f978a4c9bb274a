"""Checks of a mission before it flies."""
