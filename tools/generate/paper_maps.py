"""Write the seeded random maps of the paper's Tables 5 to 7 to missions/paper/."""

import tomli_w

from ipoa_mission.files import write_atomically
from ipoa_mission.paper.maps import MAPS, paper_map
from tools import REPOSITORY

FOLDER = REPOSITORY / "missions" / "paper"
HEAD = """\
# Random map {number} with {obstacles} obstacles, made by tools/generate/paper_maps.py: the size, landform
# and number of obstacles of the paper, which does not publish its own.
"""

if __name__ == "__main__":
    for name, (obstacles, number) in MAPS.items():
        text = HEAD.format(number=number, obstacles=obstacles) + tomli_w.dumps(paper_map(name))
        write_atomically(FOLDER / f"{name}.toml", text)
        print(FOLDER / f"{name}.toml")
