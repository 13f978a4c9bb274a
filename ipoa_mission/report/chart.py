"""Charts as SVG stretched to their box, below HTML labels of constant size."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.geometry import Vector


@dataclass(frozen=True)
class GraphAxis:
    low: float
    high: float
    label: str

    def place(self, values: Vector) -> Vector:
        """Return shares of the side, 0 to 1, (n,)."""
        return np.asarray((np.asarray(values, float) - self.low) / (self.high - self.low))

    def ticks(self, most: int = 6) -> list[float]:
        step = round_step((self.high - self.low) / most)
        return [n * step for n in range(math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9) + 1)]


def round_step(value: float) -> float:
    """Return the smallest of 1, 2, 5, 10, ... times a power of ten that is at least `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= value * (1 - 1e-9)))


def axis_over(label: str, *values: Vector, room: float = 0.06, floor: float | None = None) -> GraphAxis:
    """Pad the range above, and below without a `floor`."""
    everything = np.concatenate([np.ravel(v) for v in values]) if values else np.zeros(0)
    everything = everything[np.isfinite(everything)]
    low, high = (float(everything.min()), float(everything.max())) if len(everything) else (0.0, 1.0)
    low = low if floor is None else min(floor, low)
    span = max(high - low, 1e-6 * max(abs(high), 1.0), 1e-9)
    return GraphAxis(low if floor is not None else low - room * span, high + room * span, label)


@dataclass(frozen=True)
class Graph:
    """Two axes that draw layers of SVG, by classes of the page's style sheet."""

    x: GraphAxis
    y: GraphAxis

    def curve(self, x: Vector, y: Vector, look: str) -> str:
        """Return a line, broken at values that are not finite."""
        return f'<path class="{look}" d="{_path(self._points(x, y))}"/>'

    def band(self, x: Vector, low: Vector, high: Vector, look: str) -> str:
        outline = np.vstack([self._points(x, high), self._points(x, low)[::-1]])
        return f'<path class="{look}" d="{_path(outline)}Z"/>'

    def block(self, x: tuple[float, float], y: tuple[float, float], look: str, title: str) -> str:
        (x0, y0), (x1, y1) = self._points(np.array(x), np.array(y))
        return (
            f'<rect class="{look}" x="{min(x0, x1):.1f}" y="{min(y0, y1):.1f}" width="{abs(x1 - x0):.1f}" '
            f'height="{abs(y1 - y0):.1f}"><title>{escape(title)}</title></rect>'
        )

    def level(self, y: float, look: str) -> str:
        return self.curve(np.array([self.x.low, self.x.high]), np.array([y, y]), look)

    def html(self, name: str, layers: Sequence[str], over: str = "", tall: str = "", along: str = "") -> str:
        """Stack layers, the lowest first, with HTML `over` them; the cursor follows the series `along`."""
        grid = "".join(self.level(y, "grid") for y in self.y.ticks(5))
        return (
            f'<div class="chart {tall}" id="{name}" data-along="{along}" data-low="{self.x.low:.9g}" '
            f'data-high="{self.x.high:.9g}" role="img" aria-label="{escape(self.y.label)} over {escape(self.x.label)}">'
            f'<span class="unit y">{escape(self.y.label)}</span><div class="plot">'
            f'<svg viewBox="0 0 1000 1000" preserveAspectRatio="none"><g>{grid}</g>{"".join(layers)}</svg>'
            f'{self._tick_labels()}{over}<i class="cursor"></i></div>'
            f'<span class="unit x">{escape(self.x.label)}</span></div>'
        )

    def spot(self, x: float, y: float) -> str:
        left = float(self.x.place(np.array([x]))[0])
        up = float(self.y.place(np.array([y]))[0])
        return f"left:{100 * left:.2f}%;top:{100 - 100 * up:.2f}%"

    def _points(self, x: Vector, y: Vector) -> NDArray[np.float64]:
        return np.column_stack([1000.0 * self.x.place(x), 1000.0 * (1 - self.y.place(y))])

    def _tick_labels(self) -> str:
        sides = (("x", "left", self.x, self.x.ticks()), ("y", "bottom", self.y, self.y.ticks(5)))
        return "".join(
            f'<span class="tick {name}" style="{side}:{100 * share:.2f}%">{f"{value:.6g}".replace("-", "−")}</span>'
            for name, side, axis, values in sides
            for value, share in zip(values, axis.place(np.array(values)), strict=True)
        )


def _path(points: NDArray[np.float64]) -> str:
    pieces = []
    pen = "M"
    for x, y in points:
        if not (math.isfinite(x) and math.isfinite(y)):
            pen = "M"
            continue
        pieces.append(f"{pen}{x:.1f} {y:.1f}")
        pen = "L"
    return "".join(pieces)
