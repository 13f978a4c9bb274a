"""What the vehicle will do: items, files, firmware rules."""
