"""Serve a local page to draw, plan, prove, fly and watch a flight; the browser computes nothing."""
