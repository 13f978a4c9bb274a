"""Write tests/reference/enu.csv: geodetic positions with east, north, up by pymap3d, which is independent of PROJ.

python -m tools.generate.frame_reference
"""

import numpy as np
import pymap3d

from tools import REPOSITORY, command_line

HOMES = [
    (39.1, 121.82, 20.0),
    (0.0, 0.0, 0.0),
    (-36.8, 174.8, 3.0),
    (64.2, 179.95, 5.0),
    (-16.5, -179.99, 0.0),
    (85.0, -40.0, 900.0),
    (-89.0, 10.0, 2800.0),
]
TARGET = REPOSITORY / "tests" / "reference" / "enu.csv"


def main() -> None:
    command_line(__doc__).parse_args()
    rng = np.random.default_rng(1)
    rows = ["home_latitude_deg,home_longitude_deg,home_altitude,latitude_deg,longitude_deg,altitude,east,north,up"]
    for home in HOMES:
        for reach in (50.0, 500.0, 5_000.0, 50_000.0):
            for _ in range(4):
                azimuth, climb = rng.uniform(0, 360), rng.uniform(-50, 400)
                there = pymap3d.enu2geodetic(
                    reach * np.sin(np.radians(azimuth)), reach * np.cos(np.radians(azimuth)), climb, *home
                )
                place = [round(float(value), digits) for value, digits in zip(there, (12, 12, 6), strict=True)]
                enu = pymap3d.geodetic2enu(*place, *home)
                rows.append(",".join([*map(repr, home), *map(repr, place), *(f"{value:.6f}" for value in enu)]))
    TARGET.write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
