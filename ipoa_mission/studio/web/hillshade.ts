// Light on the scenario's ground, from the north-west, as maps have it: drawn here, from the heights that were told.
import type { World } from "./messages";

const SUN = [-0.5, 0.5, Math.SQRT1_2]; // east, north, up, of length 1
const STRENGTH = 1.6;

/** A picture of light and shadow, north up, and its corners; none where the ground is level. */
export function hillshade({ heights: { corner, step, columns, up }, degree_m }: World): { canvas: HTMLCanvasElement; corners: [[number, number], [number, number], [number, number], [number, number]] } | null {
  const rows = up.length / columns;
  if (columns < 2 || rows < 2 || Math.max(...up) - Math.min(...up) < 0.5) return null;
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const pen = canvas.getContext("2d")!, picture = pen.createImageData(columns, rows);
  const wide = step[0]! * degree_m[0]!, long = step[1]! * degree_m[1]!;
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const at = (r: number, c: number) => up[Math.min(Math.max(row + r, 0), rows - 1) * columns + Math.min(Math.max(column + c, 0), columns - 1)]!;
      const east = (at(0, 1) - at(0, -1)) / (2 * wide), north = (at(1, 0) - at(-1, 0)) / (2 * long);
      const light = (SUN[2]! - east * SUN[0]! - north * SUN[1]!) / Math.hypot(east, north, 1) - SUN[2]!; // level ground: 0
      const pixel = 4 * ((rows - 1 - row) * columns + column);
      picture.data.fill(light > 0 ? 255 : 0, pixel, pixel + 3);
      picture.data[pixel + 3] = Math.min(200, 255 * STRENGTH * Math.abs(light));
    }
  }
  pen.putImageData(picture, 0, 0);
  const [west, south] = [corner[0]! - step[0]! / 2, corner[1]! - step[1]! / 2], [east, north] = [west + columns * step[0]!, south + rows * step[1]!];
  return { canvas, corners: [[west, north], [east, north], [east, south], [west, south]] };
}
