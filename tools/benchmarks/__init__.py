"""How quick and how good: each measures, and keeps rows or prints tables that the documents show."""
