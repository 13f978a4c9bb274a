// The name of a part of the scenario, and its removal.
import { pathKey } from "./shapes";
import { edit, set, studio, type Path } from "./store";

/** Remove a part from the scenario. */
export function remove(path: Path): void {
  if (typeof path.at(-1) !== "number") return; // home, start and goal must be there
  edit(`${nameOf(path)} removed`, { op: "take", path });
  set({ selected: null });
}

export function nameOf(path: Path): string {
  const key = pathKey(path);
  const body = studio.world?.bodies.find(one => one.path && pathKey(one.path) === key);
  const spot = studio.world?.spots.find(one => pathKey(one.path) === key);
  return body?.name ?? spot?.name ?? (path[0] === "fence" ? `fence ${Number(path[1]) + 1}` : key);
}
