"""How each autopilot flies: guidance, control, body and sensors, step by step; estimates and simulator share it."""
