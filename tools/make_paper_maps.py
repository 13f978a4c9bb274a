"""Write the seeded random maps of Tables 5 to 7 to missions/paper/."""

from pathlib import Path

from ipoa_mission.experiments.maps import MAPS, paper_map
from ipoa_mission.files import write_atomically

FOLDER = Path(__file__).parent.parent / "missions" / "paper"

if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in MAPS:
        write_atomically(FOLDER / f"{name}.toml", paper_map(name))
        print(FOLDER / f"{name}.toml")
