"""The main job as one call: a scenario becomes a mission that was planned, proved, checked and timed."""
