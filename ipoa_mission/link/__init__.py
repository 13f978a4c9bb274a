"""Communicate with a vehicle: the MAVLink mission service and commands."""
