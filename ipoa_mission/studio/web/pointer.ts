// Where the pointer is: its coordinates, how high the ground is there, and what stands on it.
import type { Map as MapLibre } from "maplibre-gl";
import type { World } from "./messages";
import { studio, type LngLat } from "./store";

const shown = document.createElement("p");

export function showPointer(map: MapLibre): void {
  shown.className = "pointer";
  map.getContainer().append(shown);
  const tell = (event: { lngLat: { toArray(): number[] } }) => { shown.textContent = told(map, event.lngLat.toArray() as LngLat); };
  map.on("mousemove", tell);
  map.on("click", tell);
  map.on("mouseout", () => { shown.textContent = ""; });
}

function told(map: MapLibre, [lng, lat]: LngLat): string {
  const up = studio.world ? groundAt(studio.world, [lng, lat]) : null;
  const body = map.queryRenderedFeatures(map.project([lng, lat]), { layers: ["roofs", "roofs-space"] })[0]?.properties;
  return `${lat.toFixed(6)}, ${lng.toFixed(6)}` + (up === null ? "" : ` · ground ${(studio.world!.home_amsl + up).toFixed(1)} m AMSL, ${up.toFixed(1)} above home`)
    + (body ? ` · ${body.name}: ${Number(body.top).toFixed(1)} above home${up === null ? "" : `, ${(Number(body.top) - up).toFixed(1)} above ground`}` : "");
}

/** Show the same of a place that no pointer is at. Returns it for who does not see the map: from home first. */
export function showPlace(map: MapLibre, place: LngLat): string {
  shown.textContent = told(map, place);
  const home = studio.world?.spots.find(spot => spot.name === "home")?.place, [wide, high] = studio.world?.degree_m ?? [1, 1];
  if (!home) return shown.textContent;
  const east = Math.round((place[0] - home[0]!) * wide!), north = Math.round((place[1] - home[1]!) * high!);
  return `${Math.abs(east)} m ${east < 0 ? "west" : "east"}, ${Math.abs(north)} m ${north < 0 ? "south" : "north"} of home; ${shown.textContent}`;
}

/** The ground between the four heights about a place; none outside of the flight's bounds. */
function groundAt(world: World, place: LngLat): number | null {
  const { corner, step, columns, up } = world.heights, rows = up.length / columns;
  if (!up.length) return null;
  const x = (place[0] - corner[0]!) / step[0]!, y = (place[1] - corner[1]!) / step[1]!;
  if (!(x >= 0 && y >= 0 && x <= columns - 1 && y <= rows - 1)) return null;
  const column = Math.min(Math.floor(x), columns - 2), row = Math.min(Math.floor(y), rows - 2), [east, north] = [x - column, y - row];
  const height = (r: number, c: number) => up[(row + r) * columns + column + c]!;
  return (1 - north) * ((1 - east) * height(0, 0) + east * height(0, 1)) + north * ((1 - east) * height(1, 0) + east * height(1, 1));
}
