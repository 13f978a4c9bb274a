"""The tube: how far a flown path lies beside the predicted one, and what clearance is kept in spite of it."""
