"""Change elevation models: other system, datum, unit, type, order, missing heights, bands, or a part of a file lost."""

import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from numpy.typing import NDArray
from pyproj import Transformer

from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.maps.elevation import local_grid
from ipoa_mission.maps.geoid import ElevationRules
from tools.fuzz.outcome import Reading

HOME = Geodetic(47.5, 8.5, 500.0)
AREA = (-300.0, -250.0), (300.0, 250.0)
SPOTS = np.random.default_rng(5).uniform(AREA[0], AREA[1], (400, 2))
NEAR = 0.5  # tolerance: the posts of another system are at other places [m]
SIZE = 60
PIXELS = {"EPSG:4326": 1 / 3600, "EPSG:32632": 25.0, "EPSG:2056": 25.0, "EPSG:3857": 40.0, "EPSG:4258": 1 / 3600}
#: Systems with heights: the horizontal part, and the conversion of a height above sea level.
DATUMS: dict[str, tuple[str, float, float]] = {
    "EPSG:4326+5773": ("EPSG:4326", 1.0, 0.0), "EPSG:4326+3855": ("EPSG:4326", 1.0, 0.0),
    "EPSG:2056+5728": ("EPSG:2056", 1.0, 0.0), "EPSG:4326+8228": ("EPSG:4326", 1 / 0.3048, 0.0),
    "EPSG:4979": ("EPSG:4326", 1.0, 48.0), "EPSG:4326+5715": ("EPSG:4326", -1.0, 0.0),
    "EPSG:4326+6357": ("EPSG:4326", -1.0, 0.0), "EPSG:4326+6358": ("EPSG:4326", -1 / 0.3048, 0.0),
}  # fmt: skip
UNITS = {"ft": 1 / 0.3048, "feet": 1 / 0.3048, "US survey foot": 3937 / 1200, "m": 1.0, "meter": 1.0, "cm": 100.0,
         "km": 1e-3, "dm": 10.0, "fathom": 1 / 1.8288, "yard": 1 / 0.9144}  # fmt: skip
FILLS = [-9999.0, -32768.0, -3.4e38, 3.4e38, float("nan"), 0.0, 9999.0, 32767.0, -999.0, -99999.0, 1e20]

Field = NDArray[np.float64]


class Ground:
    """Hold heights at the test places; equal if all differ little."""

    def __init__(self, heights: Field) -> None:
        self.heights = heights

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Ground) and bool((np.abs(other.heights - self.heights) <= NEAR).all())

    __hash__ = None  # type: ignore[assignment]


def read_model(path: Path) -> Reading:
    """Read the ground about home; remarks on spacing and home do not count."""
    if path.suffix == ".hgt":  # whose name is its place
        path = path.replace(path.with_name("N47E008.hgt"))
    elif path.suffix == ".asc":
        path.with_suffix(".prj").write_text(rasterio.CRS.from_epsg(4326).to_wkt())
    grid, remarks = local_grid(path, ElevationRules(), LocalFrame(HOME), *AREA)
    words = frozenset(remark for remark in remarks if "ground every" not in remark and "ground at home" not in remark)
    return Reading(Ground(grid.height(SPOTS)), words, lambda was, now: bool((now.heights >= was.heights - NEAR).all()))


def _hills(latitude: Field, longitude: Field, slope: float) -> Field:
    east, north = (longitude - 8.5) * 75_200, (latitude - 47.5) * 111_200
    return np.asarray(500 + slope * north + 3 * np.sin(east / 400) * np.cos(north / 300))


def _model(path: Path, slope: float, system: str = "EPSG:4326", **how: Any) -> bytes:
    """Return a model as bytes; `factor` and `offset` convert heights, `fill` makes a hole."""
    flat, factor, offset = DATUMS.get(system, (system, 1.0, 0.0))
    pixel = PIXELS[flat]
    there = Transformer.from_crs("EPSG:4326", flat, always_xy=True)
    x, y = there.transform(8.5, 47.5)
    left, top = x - (SIZE / 2 + 1 / 3) * pixel, y + (SIZE / 2 + 1 / 3) * pixel
    columns, rows = np.meshgrid(left + pixel * (np.arange(SIZE) + 0.5), top - pixel * (np.arange(SIZE) + 0.5))
    longitude, latitude = there.transform(columns, rows, direction="INVERSE")
    data = _hills(latitude, longitude, slope) * factor * how.pop("factor", 1.0) + offset
    transform = rasterio.Affine(pixel, 0, left, 0, -pixel, top)
    if how.pop("south_up", False):
        data, transform = data[::-1], rasterio.Affine(pixel, 0, left, 0, pixel, top - SIZE * pixel)
    scale, zero = how.pop("scale", (1.0, 0.0))
    data = (data - zero) / scale
    if (hole := how.pop("fill", None)) is not None:
        data = data.copy()
        data[33:36, 24:28] = hole
    unit, bands, scaled = how.pop("unit", ""), how.pop("bands", [0]), how.pop("scaled", True)
    profile = {"driver": "GTiff", "dtype": "float64", "crs": system, "count": len(bands), "transform": transform} | how
    dtype = profile["dtype"]
    with (
        np.errstate(invalid="ignore", over="ignore"),
        rasterio.open(path, "w", width=SIZE, height=SIZE, **profile) as file,
    ):
        for number, kind in enumerate(bands, start=1):
            shown = data if kind == 0 else np.full_like(data, 255.0 if kind == 1 else 30.0)
            whole = np.issubdtype(np.dtype(dtype), np.integer)
            info = np.iinfo(dtype) if whole else None
            file.write((shown if info is None else np.clip(np.rint(shown), info.min, info.max)).astype(dtype), number)
        if unit:
            file.units = (unit,) * len(bands)
        if scaled and (scale, zero) != (1.0, 0.0):
            file.scales, file.offsets = (scale,) * len(bands), (zero,) * len(bands)
    return path.read_bytes()


def changed_tiff(chance: random.Random, folder: Path) -> tuple[str, bytes, bytes]:
    path, slope = folder / "model.tif", chance.uniform(-0.02, 0.02)
    before = _model(path, slope)
    changes = ["system", "datum", "unit", "unit lost", "scale", "type", "hole", "bands", "order", "cut", "block"]
    change, how = chance.choice(changes), dict[str, Any]()
    match change:
        case "system":
            how["system"] = chance.choice([*PIXELS])
        case "datum":
            how["system"] = chance.choice([*DATUMS])
        case "unit":
            how["unit"] = chance.choice([*UNITS])
            how["factor"] = UNITS[how["unit"]]
        case "unit lost":
            how["factor"] = chance.choice([*UNITS.values()])
        case "scale":
            how |= {"scale": chance.choice([(0.1, 400.0), (0.01, 0.0), (0.3048, 0.0)]), "dtype": "int32"}
            how["scaled"] = chance.random() < 0.7
        case "type":
            how["dtype"] = chance.choice(["int16", "uint16", "float32", "int32", "uint8"])
        case "hole":
            how |= {"fill": chance.choice(FILLS), "dtype": chance.choice(["float64", "float32"])}
            if chance.random() < 0.4:
                how["nodata"] = how["fill"]
        case "bands":
            how["bands"] = chance.choice([[0, 1], [1, 0], [0, 2], [2, 0], [0, 0]])
        case "order":
            how |= chance.choice([{"south_up": True}, {"tiled": True, "blockxsize": 16, "blockysize": 16}])
            how |= chance.choice([{}, {"compress": "deflate"}, {"compress": "lzw", "predictor": 2}])
            how["dtype"] = "int16" if "predictor" in how else "float32"
        case _:
            tiled = {"tiled": True, "blockxsize": 16, "blockysize": 16}
            laid_out: list[dict[str, Any]] = [{}, {"compress": "deflate"}, tiled]
            before = _model(path, slope, **chance.choice(laid_out))
            return change, before, spoiled(before, change, chance)
    return change, before, _model(path, slope, **how)


def spoiled(data: bytes, change: str, chance: random.Random) -> bytes:
    if change == "cut":
        return data[: chance.randrange(len(data))]
    at = chance.randrange(len(data))
    size = chance.choice([16, 512, 4096])
    block = bytes(size) if chance.random() < 0.5 else chance.randbytes(size)
    return (data[:at] + block + data[at + size :])[: len(data)]


@cache
def _tile() -> NDArray[np.int16]:
    """Return a tile of SRTM, every 3 seconds."""
    latitude, longitude = np.meshgrid(48 - np.arange(1201) / 1200, 8 + np.arange(1201) / 1200, indexing="ij")
    return np.clip(_hills(latitude, longitude, 0.01), 400, 600).astype(">i2")


def changed_tile(chance: random.Random, _: Path) -> tuple[str, bytes, bytes]:
    tile = _tile()
    change = chance.choice(["cut", "block", "hole", "lose", "order"])
    match change:
        case "hole":
            changed = tile.copy()
            changed[598:603, 598:603] = chance.choice([-32768, 0, -9999, 9999, 32767])
            after = changed.tobytes()
        case "block":
            at = 2 * 1201 * chance.randrange(590, 610)
            block = bytes(3000) if chance.random() < 0.5 else chance.randbytes(3000)
            after = tile.tobytes()[:at] + block + tile.tobytes()[at + len(block) :]
        case "lose":
            after = np.delete(tile, chance.randrange(1201), axis=chance.randrange(2)).tobytes()
        case "order":
            after = tile.astype("<i2").tobytes()
        case _:
            after = tile.tobytes()[: chance.randrange(tile.nbytes)]
    return change, tile.tobytes(), after


def changed_grid(chance: random.Random, folder: Path) -> tuple[str, str, str]:
    _model(folder / "model.asc", chance.uniform(-0.02, 0.02), driver="AAIGrid", dtype="float32", nodata=-9999)
    before = (folder / "model.asc").read_text()
    lines = before.splitlines()
    head = next(n for n, line in enumerate(lines) if line.strip()[0].isdigit())
    at = chance.randrange(head, len(lines))
    values = lines[at].split()
    change = chance.choice(["rename", "reorder", "drop", "double", "cut", "hole", "convert", "wrap", "lose"])
    match change:
        case "rename":
            n = chance.randrange(head)
            key, value = lines[n].split()
            names = key.lower(), key.upper(), key[:-1], key.replace("corner", "center"), "dx"
            lines[n] = f"{chance.choice(names)} {value}"
        case "reorder" if chance.random() < 0.5:
            lines[:head] = chance.sample(lines[:head], head)
        case "reorder":
            lines[head:] = lines[head:][::-1]
            return "upside down", before, before  # not detectable
        case "drop":
            del lines[chance.randrange(head)]
        case "double":
            lines.insert(at, lines[at])
        case "cut":
            return change, before, before[: chance.randrange(len(before))]
        case "hole":
            values[20:26] = [chance.choice(["-9999", "-32768", "nan", "0", "1e20", "*", "9999"])] * 6
            lines[at] = " ".join(values)
            if chance.random() < 0.5:
                lines = [line for line in lines if "nodata" not in line.lower()]
        case "convert":
            lines[at] = lines[at].replace(".", ",")
        case "wrap":
            lines[head:] = [" ".join(" ".join(lines[head:]).split())]
        case _:
            del lines[at]
    return change, before, "\n".join(lines) + "\n"
