"""Find the errors and risks of a mission; read `check` first.

`ipoa_mission/rules.py` explains their codes. `unsafe` turns errors into refusals, and checks a flight begun elsewhere.
"""
