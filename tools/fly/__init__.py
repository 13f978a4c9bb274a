"""What flies on real autopilots, and trims their logs."""
