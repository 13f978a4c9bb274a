"""Verbs import heavy modules when they run."""
