"""The MAVLink mission service and commands."""
