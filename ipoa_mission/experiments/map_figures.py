"""Figures 9 to 11 of the paper: the paths on the maps, from the front and from above, drawn from rows of runs."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ipoa_mission.experiments.figures import COLOURS, draw_svg, legend_of_all, panels_of
from ipoa_mission.experiments.published import ALGORITHMS
from ipoa_mission.experiments.rows import Row
from ipoa_mission.planning.spline import Spline
from ipoa_mission.scenario import Scenario


def paths_on_maps(rows: Sequence[Row], scenarios: dict[str, Scenario]) -> str:
    """For each map, from above and from the front, the path of each algorithm: of its runs the one that costs least."""
    figure, panels = panels_of(len(scenarios), 2, 11, 4.6 * len(scenarios))
    for (case, scenario), above, front in zip(scenarios.items(), panels[::2], panels[1::2], strict=True):
        _draw_world(above, front, scenario)
        for name in ALGORITHMS:
            best = min(
                (row for row in rows if (row.trial.case, row.trial.algorithm) == (case, name)), key=lambda r: r.cost
            )
            control = np.array(best.measures["control"], dtype=np.float64).reshape(-1, 3)
            path = Spline(control).points(np.linspace(0, 1, 300))
            style = "-" if best.measures["feasible"] else ":"
            above.plot(path[:, 0], path[:, 1], style, color=COLOURS[name], lw=1.4, zorder=3)
            front.plot(path[:, 0], path[:, 2], style, color=COLOURS[name], lw=1.4, zorder=3)
            above.plot([], [], "-", color=COLOURS[name], label=name.upper())
        above.set(title=f"{case}, from above", xlabel="east [m]", ylabel="north [m]", aspect="equal")
        front.set(title=f"{case}, from the south", xlabel="east [m]", ylabel="up [m]")
    legend_of_all(figure, panels[0])
    return draw_svg(figure)


def _draw_world(above: Any, front: Any, scenario: Scenario) -> None:
    """Height of the ground and ground plans of the obstacles; from the south, outlines over the highest ground."""
    bounds = scenario.airspace.bounds
    east = np.linspace(bounds.lower[0], bounds.upper[0], 121)
    north = np.linspace(bounds.lower[1], bounds.upper[1], 121)
    grid = np.stack(np.meshgrid(east, north), axis=-1)
    ground = scenario.airspace.ground(grid.reshape(-1, 2)).reshape(121, 121)
    extent = (east[0], east[-1], north[0], north[-1])
    above.imshow(ground, extent=extent, origin="lower", cmap="Greens", alpha=0.7, interpolation="none")
    front.fill_between(east, ground.max(axis=0), ground.min(), color="0.85")
    for body in scenario.airspace.obstacles:
        above.fill(*body.outline()[0].T, color="0.4")
        front.fill(*body.silhouette(0).T, facecolor="0.3", edgecolor="0.4", alpha=0.35)
