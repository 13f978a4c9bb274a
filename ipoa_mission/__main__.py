"""`python -m ipoa_mission`: the command line."""

from ipoa_mission.cli.app import main

main()
