"""From an area to the quickest order of lines over it, and how much of it they see."""
