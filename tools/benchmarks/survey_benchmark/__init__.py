"""Surveys of areas with holes, side by side with other planners."""
