// What the map draws, as GeoJSON: the world, a path, its ribbon in space.
import type { MapLine, Plan, World } from "./messages";
import type { LngLat, Path } from "./store";

type Feature = GeoJSON.Feature;

export function collection(features: Feature[]): GeoJSON.FeatureCollection {
  return { type: "FeatureCollection", features };
}

const polygon = (rings: unknown, properties: Record<string, unknown>): Feature =>
  ({ type: "Feature", properties, geometry: { type: "Polygon", coordinates: rings as LngLat[][] } });

export function line(points: unknown, properties: Record<string, unknown> = {}): Feature {
  return { type: "Feature", properties, geometry: { type: "LineString", coordinates: points as LngLat[] } };
}

/** Terraces from low to high; `share` is how high each is among them, `rise` how far above the lowest ground. */
export function ground(world: World): Feature[] {
  const levels = world.ground.map(terrace => terrace.up);
  const low = levels[0] ?? 0, high = levels.at(-1) ?? 1;
  return world.ground.flatMap(terrace => terrace.polygons.map(rings => polygon(rings, {
    up: terrace.up, rise: terrace.up - low, share: (terrace.up - low) / Math.max(high - low, 1),
  })));
}

export function lowest(world: World): number {
  return world.ground[0]?.up ?? Math.min(0, world.floor);
}

/** How the maps' names begin for what looks otherwise than a building. */
const LOOKS: [string, RegExp][] = [["tree", /^(tree|row of trees|wood|scrub|forest|hedge)\b/], ["wire", /^(power|[\d.]+ kV) line\b/]];

/** Obstacles and zones; those that the scenario itself draws carry the path to them. */
export function bodies(world: World): Feature[] {
  const floor = lowest(world);
  const highest = Math.max(1, ...world.bodies.filter(body => body.solid).map(body => body.top));
  return world.bodies.map(body => polygon(body.rings, {
    name: body.name, solid: body.solid, doubt: body.doubt ?? false, base: body.base, top: body.top, path: body.path ? pathKey(body.path) : "",
    share: Math.max(0, body.top) / highest, look: LOOKS.find(([, names]) => names.test(body.name))?.[0] ?? "",
    from: Math.max(0, body.base - floor), to: Math.max(0.1, Math.min(body.top, world.ceiling + 40) - floor),
  }));
}

export function fences(world: World): Feature[] {
  return world.fences.map(fence => polygon([fence.ring], { inclusion: fence.inclusion, path: pathKey(fence.path) }));
}

export function bounds(world: World): Feature[] {
  return [line([...world.around, world.around[0]])];
}

export function deviationBound(plan: Plan): Feature[] {
  return plan.deviation_ring.length ? [polygon(plan.deviation_ring, {})] : [];
}

export const METERS = 111_320; // of a degree of latitude, closely enough to draw by

/** A path as a band of boxes in the air, `wide` meters across: what a map of extrusions can show of it; one that is not proved in pieces. */
export function ribbon(path: MapLine, floor: number, wide: number, high: number, look: "proved" | "coarse" | "broken" = "proved"): Feature[] {
  const points = path.points as LngLat[];
  const features: Feature[] = [];
  const narrow = Math.cos(((points[0]?.[1] ?? 0) * Math.PI) / 180);
  let along = 0, from = 0;
  for (let n = 1; n < points.length; n++) {
    const [west, south] = points[from]!, [east, north] = points[n]!;
    const dx = (east - west) * METERS * narrow, dy = (north - south) * METERS;
    const length = Math.hypot(dx, dy);
    const steep = length < UPRIGHT && n < points.length - 1 && nearly(points[from]!, points[n + 1]!, narrow);
    if (steep) continue; // a climb on the spot is one post, not as many specks as it has samples
    const ends = path.up.slice(from, n + 1).map(up => up - floor);
    from = n;
    const heights = { from: Math.max(0, Math.min(...ends) - high / 2), to: Math.max(0.1, Math.max(...ends) + high / 2), look };
    along += length;
    if (look !== "proved" && Math.floor(along / (4 * wide)) % 2) continue;
    if (length < UPRIGHT) {
      if (heights.to - heights.from > 1.5 * high) features.push(...pillar([east, north], heights.from, heights.to));
      continue;
    }
    const aside = wide / 2 / length / METERS;
    const [x, y] = [(-dy * aside) / narrow, dx * aside];
    features.push(polygon(
      [[[west + x, south + y], [east + x, north + y], [east - x, north - y], [west - x, south - y], [west + x, south + y]]],
      heights,
    ));
  }
  return features;
}

const UPRIGHT = 0.3; // what goes no farther than this goes straight up or down [m]

function nearly([west, south]: LngLat, [east, north]: LngLat, narrow: number): boolean {
  return Math.hypot((east - west) * METERS * narrow, (north - south) * METERS) < UPRIGHT;
}

/** An upright post, a meter and a half wide. */
export function pillar([lng, lat]: LngLat, from: number, to: number): Feature[] {
  const half = 0.75 / METERS, wide = half / Math.cos((lat * Math.PI) / 180);
  const ring = [[lng - wide, lat - half], [lng + wide, lat - half], [lng + wide, lat + half], [lng - wide, lat + half], [lng - wide, lat - half]];
  return [polygon([ring], { from, to: Math.max(to, from + 0.1) })];
}

export function pathKey(path: Path): string {
  return path.join(".");
}

export function keyPath(key: string): Path {
  return key.split(".").map(step => (/^\d+$/.test(step) ? Number(step) : step));
}
