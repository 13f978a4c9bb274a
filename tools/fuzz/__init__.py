"""Spoiled input for as long as one likes."""
