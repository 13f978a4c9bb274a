"""Flights from logs, and vehicles learned from them."""
