"""Show a flight: `page` writes one HTML file of `panels`, `exports` other formats, `plots` pictures for papers.

Read `drawn_flight` first: it computes paths, times and marks.
"""
