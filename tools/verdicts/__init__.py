"""What a real autopilot says to generated items, recorded; tests/verdicts.py holds our tables against it."""
