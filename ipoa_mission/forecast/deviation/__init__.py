"""The deviation bound: distance of flown from predicted paths, and the clearance that remains."""
