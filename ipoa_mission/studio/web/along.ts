// Where on its course a vehicle is.
import type { Course } from "./messages";

const AHEAD = 200; // so far on from where it was it is sought [m]
const LATER = 0.1; // a sample counts as farther away by so much of the way to it: where the course comes back, the first is meant

/** The sample of a course that is nearest to a place, from sample `at` on. */
export function sampleNear({ along, line: { points } }: Course, [lng, lat]: number[], at: number): number {
  const wide = Math.cos((lat! * Math.PI) / 180), end = along[at]! + AHEAD;
  let best = at, least = Infinity;
  for (let i = at; i < points.length && along[i]! <= end; i++) {
    const away = 111_320 * Math.hypot((points[i]![0]! - lng!) * wide, points[i]![1]! - lat!) + LATER * (along[i]! - along[at]!);
    if (away < least) [least, best] = [away, i];
  }
  return best;
}
