"""The course of a mission's flight: visits, legs, splines."""
