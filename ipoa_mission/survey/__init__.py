"""Plan the quickest order of lines over an area, and compute how much of it they see."""
