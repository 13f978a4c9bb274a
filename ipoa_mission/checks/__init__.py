"""Find the errors and risks of a mission; read `check` first.

Each check yields findings of a code that `ipoa_mission/rules.py` explains. `unsafe` turns errors into refusals, and
checks a flight that begins elsewhere.
"""
