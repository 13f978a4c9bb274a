"""Tests of the package, and their helpers."""
