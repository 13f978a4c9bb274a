"""Serve a local web page to draw, plan, prove, fly and watch a flight.

The package's own functions compute everything that the page shows; the browser plans and proves nothing.
"""
