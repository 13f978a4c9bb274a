"""Flights out of logs, and what one vehicle is like, learned from them."""
