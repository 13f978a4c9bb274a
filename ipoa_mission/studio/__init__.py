"""The studio: a local web page on which a flight is drawn, planned, proved, flown and watched.

The page shows what the package's own functions answer; nothing is planned, proved or timed in the browser.
"""
