"""What a flight takes out of the battery, and whether it may."""
