import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import ipoa_mission as api
from ipoa_mission.geometry import Points
from ipoa_mission.report.plots import PATH_STYLES
from ipoa_mission.scenario import read_scenario
from ipoa_mission.world.obstacles import Cylinder, Obstacle, Prism, Sphere
from tests.refused import refuses

COURTYARD = Prism("courtyard", ((0, 0), (30, 0), (30, 20), (0, 20)), (((10, 5), (20, 5), (20, 15), (10, 15)),), 0, 12)
TOWER = Cylinder("tower", 5, 5, 4, 0, 30)
BALL = Sphere("ball", (0, 0, 20), 8)


@pytest.mark.parametrize("body", [COURTYARD, TOWER, BALL], ids=lambda body: body.name)
def test_outlines_and_silhouettes_fill_the_obstacles_box(body: Obstacle) -> None:
    plan = np.vstack(body.outline())
    assert np.allclose([plan.min(axis=0), plan.max(axis=0)], body.bounds[:, :2])
    for axis in (0, 1):
        shadow = body.silhouette(axis)
        assert np.allclose([shadow.min(axis=0), shadow.max(axis=0)], body.bounds[:, [axis, 2]])


@pytest.mark.long
def test_the_same_scenario_and_paths_give_the_same_bytes(missions: Path, tmp_path: Path) -> None:
    scenario = read_scenario(missions / "sitl.toml")
    paths = {"straight": np.array([scenario.start_point, scenario.goal_point])}
    suffixes = (".png", ".svg", ".pdf")
    for name in "ab":
        figure = api.draw_views(scenario, paths, views=("top", "front"))
        for suffix in suffixes:
            api.write_picture(figure, tmp_path / f"{name}{suffix}")
    for suffix in suffixes:
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_a_view_shows_every_path_and_every_obstacle(missions: Path, tmp_path: Path) -> None:
    scenario = read_scenario(missions / "campus.toml")
    path = np.array([scenario.start_point, [100, 100, 50], scenario.goal_point])
    figure = api.draw_views(scenario, {"one": path, "other": path + 5}, views=("top",))
    api.write_picture(figure, tmp_path / "top.svg")
    assert ET.parse(tmp_path / "top.svg").getroot().tag.endswith("svg")
    axes = figure.axes[0]
    assert len(axes.patches) == len(scenario.obstacles)
    drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
    assert np.allclose(drawn["other"], path[:, :2] + 5)


def test_another_suffix_is_refused_by_name(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    with refuses("wrong-suffix", "picture.bmp"):
        api.write_picture(Figure(), tmp_path / "picture.bmp")


#: Machado, Oliveira and Fernandes 2009, table 1, severity 1.0 (linear RGB).
DICHROMACY = {
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


@pytest.mark.parametrize("eye", DICHROMACY)
def test_the_first_five_path_colors_stay_apart_for_color_blind_eyes(eye: str) -> None:
    from matplotlib.colors import to_rgb

    linear = np.array([[_linear(c) for c in to_rgb(color)] for color, _ in PATH_STYLES[:5]])
    seen = _lab(np.clip(linear @ np.array(DICHROMACY[eye]).T, 0, 1))
    apart = np.linalg.norm(seen[:, None] - seen, axis=2) + 1e3 * np.eye(5)
    assert apart.min() > 10  # CIE 1976 color difference; 2.3 is just noticeable


def _linear(channel: float) -> float:
    return channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4


def _lab(linear: Points) -> Points:
    """CIELAB of linear sRGB under D65 (IEC 61966-2-1, CIE 15)."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = linear @ to_xyz.T / np.array([0.9505, 1.0, 1.0890])
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.column_stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])])
