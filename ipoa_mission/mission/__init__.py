"""Mission files, and missions as wire items."""
