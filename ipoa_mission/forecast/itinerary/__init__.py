"""What the vehicle meets as it flies a mission: visits, legs, splines."""
