"""Benchmarks of speed and quality, which store rows or print tables for the docs."""
