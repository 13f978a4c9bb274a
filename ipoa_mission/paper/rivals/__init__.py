"""Implement the paper's rivals; entry points register them as optimizers."""
