"""Search: algorithms that propose candidates and are told their costs. They know nothing of what is optimized."""
