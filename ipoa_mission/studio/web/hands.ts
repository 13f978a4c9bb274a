// What hands do on the map: choose and drag things, draw new ones. Drawings become tables of the scenario.
import type { Map as MapLibre, MapMouseEvent, MapTouchEvent } from "maplibre-gl";
import type { Body, Spot } from "./messages";
import { nameOf, remove } from "./chosen";
import { useCross } from "./cross";
import { addItem, placeForNew, takeItem } from "./items";
import { draft, fit, placesOf } from "./map";
import { keyPath, line, pathKey } from "./shapes";
import { chooseItem, drag, edit, endDrag, isMission, isWritten, listen, set, studio, SURVEY, type Change, type LngLat, type Path, type Tool } from "./store";

const HEIGHT = 15; // of what is drawn, until it is given another [m]
const RADIUS = 3; // of a mast [m]
const WAYPOINT = 16; // its MAV_CMD
const CLOSE = 12; // pixels from the first corner within which a polygon is closed
const PICKED = ["roofs", "roofs-space", "keep-out", "fence-lines"];
const WORDS: Record<string, string> = {
  measure: "Click from place to place. Esc ends it.",
  waypoint: "Click where the next waypoint is to be; it comes after the item that is chosen. Esc ends it.",
  via: "Click where the flight is to pass. Esc ends it.",
  polygon: "Click corner by corner; click the first again, or press Enter, to close it. Esc gives it up.",
  cylinder: "Click where the mast or tree stands.",
  "keep-out": "Click the corners of the area to keep out of; Enter closes it.",
  "keep-in": "Click the corners of the area to stay in; Enter closes it.",
  area: "Click the corners of the area to be surveyed; click the first again, or press Enter, to close it. Esc gives it up.",
  hole: "Click the corners of what is left out of the area; Enter closes it.",
  corridor: "Click along the middle of the corridor to be surveyed; Enter ends it.",
};

export function useHands(map: MapLibre): void {
  let corners: LngLat[] = [];
  const show = (pointer?: LngLat) => {
    const points = pointer && corners.length ? [...corners, pointer] : corners;
    const closes = points.length > 2 && !isOpen(studio.tool);
    if (points.length > 1) set({ notice: `${lengths(points, closes)}${closes ? ". Enter, a double click or the first corner closes it." : ""}` });
    draft(map, [
      ...(points.length > 1 ? [line(points)] : []),
      ...(closes ? [line([points.at(-1)!, points[0]!], { closing: true })] : []),
      ...corners.map(place => ({ type: "Feature" as const, properties: {}, geometry: { type: "Point" as const, coordinates: place } })),
    ]);
  };
  const giveUp = () => { corners = []; show(); };
  const close = () => {
    if (studio.tool === "corridor" && corners.length > 1) addArea("corridor", corners);
    else if (corners.length > 2 && !isOpen(studio.tool)) addRing(corners);
    giveUp();
  };
  /** Use the tool at a place; `closes`: it is so near to the first corner that it closes what is drawn. */
  const press = (at: LngLat, closes: boolean): string => {
    const tool = studio.tool;
    if (tool === "waypoint") addItem(placeForNew(studio), WAYPOINT, at);
    else if (tool === "via" || tool === "rally") addPlace(tool, at);
    else if (tool === "cylinder") addMast(at);
    else if (!isOpen(tool) && corners.length > 2 && closes) {
      close();
      return "Closed; its numbers stand at the side.";
    } else {
      corners.push(at);
      show();
      return `Corner ${corners.length}. ${corners.length > 1 ? studio.notice : ""}`;
    }
    return `${tool === "cylinder" ? "Mast" : tool === "waypoint" ? "Waypoint" : "Point"} added.`;
  };

  map.on("click", event => {
    if (studio.tool === "select") choose(map, event);
    else press(event.lngLat.toArray() as LngLat, corners.length > 0 && near(map, event.lngLat.toArray() as LngLat, corners[0]!));
  });
  map.on("dblclick", event => {
    if (!corners.length || studio.tool === "measure") return;
    event.preventDefault(); // it is no zoom
    corners.pop(); // its second click
    close();
  });
  map.on("mousemove", event => {
    if (corners.length) show(event.lngLat.toArray() as LngLat);
    map.getCanvas().style.cursor = studio.tool !== "select" ? "crosshair" : itemAt(map, event) !== null && isMission(studio) || (pick(map, event) ?? SURVEY) !== SURVEY ? "move" : "";
  });
  map.on("mousedown", event => {
    if (studio.tool !== "select" || studio.space) return;
    if (event.originalEvent.target !== map.getCanvas()) return; // a button is dragged, and nothing that lies below it
    if (isMission(studio)) grabItem(map, event);
    else grab(map, event);
  });
  map.on("touchstart", event => { if (studio.tool === "select" && isMission(studio) && !studio.space && event.points.length === 1) grabItem(map, event); });
  addEventListener("keydown", event => {
    if (event.key === "Escape") giveUp();
    if (event.key === "Enter" && corners.length && !cross.isShown()) close();
  });
  listen((now, before) => {
    if (now.tool !== before.tool) {
      giveUp();
      set({ notice: WORDS[now.tool] ?? "" });
      if (now.tool === "select") map.doubleClickZoom.enable();
      else map.doubleClickZoom.disable();
    }
  });
  addEventListener("keydown", event => {
    const free = !(event.target instanceof HTMLElement && event.target.matches("input, textarea, select"));
    if (free && event.key === "Home" && studio.world) fit(map, studio.world);
    if (free && (event.key === "Delete" || event.key === "Backspace") && studio.selected) remove(studio.selected);
    else if (free && event.key === "Delete" && isMission(studio) && studio.item !== null) takeItem(studio.item);
  });
  const carried = useCarrying(map);
  const cross = useCross(map, {
    press: at => {
      if (studio.tool === "select") return carried.press(at);
      const last = corners.at(-1), again = last && isSame(at, last) && studio.tool !== "measure";
      if (!again) return press(at, corners.length > 0 && isSame(at, corners[0]!));
      if (corners.length < (studio.tool === "corridor" ? 2 : 3)) return `${corners.length} corner${corners.length > 1 ? "s" : ""}: too few to close it.`;
      close();
      return "Closed; its numbers stand at the side.";
    },
    over: at => (studio.tool === "select" ? carried.over(at) : show(at)),
    back: () => {
      if (!corners.pop()) return null;
      return `The last corner is taken back; ${corners.length} left.`;
    },
    letGo: () => carried.letGo(),
  });
}

/** Whether what is drawn ends where it ends. */
const isOpen = (tool: Tool) => tool === "measure" || tool === "corridor";

function addPlace(to: "via" | "rally", place: LngLat): void {
  const start = studio.world?.spots.find(spot => spot.name === "start");
  const at = (studio.document?.scenario[to] ?? []).length;
  edit(`${to === "via" ? "via point" : "rally point"} added`, { op: "add", to, table: like(start), place, ring: null, at: null });
  set({ selected: [to, at] });
}

/** As high as the start, and counted from where the goal's height is. */
function like(start: Spot | undefined): Record<string, number> {
  const goal = studio.document?.scenario.goal ?? {};
  return "height_above_ground" in goal ? { height_above_ground: round(start?.above_ground ?? 20) } : { up: round(start?.up ?? 20) };
}

function addMast(place: LngLat): void {
  const at = (studio.document?.scenario.obstacles ?? []).length;
  const table = { kind: "cylinder", name: `mast ${at + 1}`, radius: RADIUS, height: HEIGHT };
  edit("mast added", { op: "add", to: "obstacles", table, place, ring: null, at: null });
  set({ tool: "select", selected: ["obstacles", at] });
}

/** An area joins the survey, or begins one; its corners are there to be moved. */
function addArea(what: "area" | "hole" | "corridor", ring: LngLat[]): void {
  edit(`${what} drawn`, { op: "draw_area", what, ring: ring as [LngLat, LngLat, ...LngLat[]] });
  set({ tool: "select", selected: SURVEY });
}

function addRing(ring: LngLat[]): void {
  if (studio.tool === "area" || studio.tool === "hole") return addArea(studio.tool, ring);
  if (studio.tool === "polygon") {
    const at = (studio.document?.scenario.obstacles ?? []).length;
    const table = { kind: "prism", name: `building ${at + 1}`, height: HEIGHT };
    edit("building added", { op: "add", to: "obstacles", table, place: null, ring, at: null });
    set({ tool: "select", selected: ["obstacles", at] });
  } else {
    const at = (studio.document?.scenario.fence ?? []).length;
    edit("fence added", { op: "add", to: "fence", table: { inclusion: studio.tool === "keep-in" }, place: null, ring, at: null });
    set({ tool: "select", selected: ["fence", at] });
  }
}

function choose(map: MapLibre, event: Touched): void {
  const item = itemAt(map, event);
  if (item !== null) chooseItem(item);
  else if (isMission(studio)) set({ item: null });
  set({ selected: pick(map, event) });
}

/** The number of the item under the pointer. */
function itemAt(map: MapLibre, { point: { x, y } }: Touched): number | null {
  const item = map.queryRenderedFeatures([[x - 6, y - 6], [x + 6, y + 6]], { layers: ["items"] })[0];
  return item ? Number(item.properties.seq) : null;
}

type Grip = MapMouseEvent | MapTouchEvent;
type Touched = Pick<Grip, "point">;

/** Drag an item of a mission: the legs to it and from it go along; where it is let go it is checked and timed. */
function grabItem(map: MapLibre, event: Grip): void {
  const seq = itemAt(map, event), from = event.point;
  if (seq === null) return;
  const item = studio.mission?.items.find(one => one.seq === seq), places = placesOf(studio), at = places.findIndex(one => one.seq === seq);
  event.preventDefault();
  chooseItem(seq);
  if (!item || item.part_of) return;
  let put: LngLat | null = null;
  const move = (to: Grip) => {
    if (!put && Math.hypot(to.point.x - from.x, to.point.y - from.y) <= 3) return;
    put = to.lngLat.toArray() as LngLat;
    const ends = [places[at - 1]?.place, put, places[at + 1]?.place].filter(place => place !== undefined);
    draft(map, [line(ends), { type: "Feature", properties: {}, geometry: { type: "Point", coordinates: put } }]);
  };
  const drop = () => {
    for (const kind of ["mousemove", "touchmove"] as const) map.off(kind, move);
    for (const kind of ["mouseup", "touchend"] as const) removeEventListener(kind, drop);
    draft(map, []);
    if (put) edit(`item ${seq} moved`, { op: "move_item", seq, place: put });
  };
  for (const kind of ["mousemove", "touchmove"] as const) map.on(kind, move);
  for (const kind of ["mouseup", "touchend"] as const) addEventListener(kind, drop);
}

/** The path to what is under the pointer, if the scenario itself draws it. */
function pick(map: MapLibre, event: Touched): Path | null {
  if (isMission(studio)) return null;
  const features = map.queryRenderedFeatures(event.point, { layers: PICKED });
  const key = features.find(feature => feature.properties.path)?.properties.path as string | undefined;
  if (key) return keyPath(key);
  return map.queryRenderedFeatures(event.point, { layers: ["area-fill", "area-lines"] }).length ? SURVEY : null;
}

/** Drag a building or a fence: its outline goes along, the path is sketched anew, and where it is let go it stays. */
function grab(map: MapLibre, event: MapMouseEvent): void {
  const path = pick(map, event), taken = event.lngLat.toArray() as LngLat;
  if (!path || path === SURVEY) return; // an area is moved by its handle: the map below it can be dragged
  event.preventDefault();
  const ring = ringOf(path);
  let moved = false, put: LngLat = taken;
  const shift = (): Change => ({ op: "shift", path, taken, put_down: put });
  const move = (to: MapMouseEvent) => {
    put = to.lngLat.toArray() as LngLat;
    moved ||= Math.hypot(to.point.x - event.point.x, to.point.y - event.point.y) > 3;
    if (!moved) return;
    draft(map, [line(ring.map(([lng, lat]) => [lng + put[0] - taken[0], lat + put[1] - taken[1]]))]);
    drag([shift()]);
  };
  map.on("mousemove", move);
  const drop = () => {
    map.off("mousemove", move);
    draft(map, []);
    endDrag();
    if (moved) edit(`${nameOf(path)} moved`, shift());
    set({ selected: path });
  };
  addEventListener("mouseup", drop, { once: true });
}

interface Carried {
  name: string;
  taken: LngLat;
  change: (put: LngLat) => Change;
  drawn: (put: LngLat) => LngLat[];
}

/** Take hold of what is at a place and put it down at another, by keyboard. */
function useCarrying(map: MapLibre) {
  let held: Carried | null = null;
  const drop = () => {
    held = null;
    draft(map, []);
    endDrag();
  };
  listen((now, before) => { if (held && now.document !== before.document) drop(); }); // it may be there no more
  return {
    press: (at: LngLat): string => {
      if (held) {
        const { name, change } = held;
        drop();
        edit(`${name} moved`, change(at));
        return `${name} put down.`;
      }
      held = carriedAt(map, at);
      return held ? `${held.name} taken: arrow keys carry it, Enter puts it down, Delete takes it out.` : studio.selected === SURVEY ? "The area is chosen: its corners are buttons behind the map." : "Nothing is here.";
    },
    over: (at: LngLat) => {
      if (!held) return;
      draft(map, [line(held.drawn(at))]);
      if (!isMission(studio)) drag([held.change(at)]);
    },
    letGo: (): boolean => {
      const had = held !== null;
      if (had) drop();
      return had;
    },
  };
}

/** What is chosen at a place, and can be carried from there. */
function carriedAt(map: MapLibre, at: LngLat): Carried | null {
  const touched = { point: map.project(at) }, spot = isMission(studio) ? undefined : studio.world!.spots.find(one => isWritten(one.path) && near(map, at, one.place as LngLat));
  if (spot) set({ selected: spot.path });
  else choose(map, touched);
  const { selected, item } = studio;
  if (isMission(studio)) {
    const places = placesOf(studio), n = places.findIndex(one => one.seq === item), taken = places[n]?.place;
    if (!taken || studio.mission?.items.find(one => one.seq === item)?.part_of) return null;
    const drawn = (put: LngLat) => [places[n - 1]?.place, put, places[n + 1]?.place].filter(place => place !== undefined);
    return { name: `item ${item}`, taken, change: put => ({ op: "move_item", seq: item!, place: put }), drawn };
  }
  if (!selected || selected === SURVEY) return null;
  const taken = spot ? spot.place as LngLat : at, ring = spot ? [taken, taken] : ringOf(selected);
  return {
    name: nameOf(selected), taken, change: put => ({ op: "shift", path: selected, taken, put_down: put }),
    drawn: put => ring.map(([lng, lat]) => [lng + put[0] - taken[0], lat + put[1] - taken[1]]),
  };
}

function ringOf(path: Path): LngLat[] {
  const key = pathKey(path);
  const body: Body | undefined = studio.world?.bodies.find(one => one.path && pathKey(one.path) === key);
  const fence = studio.world?.fences.find(one => pathKey(one.path) === key);
  return (body?.rings[0] ?? fence?.ring ?? []) as LngLat[];
}

/** How long what is being drawn is: its last edge, the way so far or all round, and its area. */
function lengths(points: LngLat[], closes: boolean): string {
  const [wide, high] = studio.world!.degree_m as [number, number];
  const flat = points.map(([lng, lat]) => [(lng - points[0]![0]) * wide, (lat - points[0]![1]) * high] as const);
  const edges = flat.slice(1).map((to, n) => Math.hypot(to[0] - flat[n]![0], to[1] - flat[n]![1]));
  const way = edges.reduce((sum, edge) => sum + edge, 0), last = `${edges.at(-1)!.toFixed(1)} m`;
  if (!closes) return edges.length > 1 ? `${last}; in all ${way.toFixed(1)} m` : last;
  const around = way + Math.hypot(...flat.at(-1)!);
  const area = Math.abs(flat.reduce((sum, [x, y], n) => sum + x * flat[(n + 1) % flat.length]![1] - flat[(n + 1) % flat.length]![0] * y, 0)) / 2;
  return `${last}; around ${around.toFixed(1)} m; ${area.toFixed(0)} m²`;
}

function near(map: MapLibre, one: LngLat, other: LngLat): boolean {
  const here = map.project(one), there = map.project(other);
  return Math.hypot(there.x - here.x, there.y - here.y) < CLOSE;
}

/** Whether arrow keys have led back to a place. */
const isSame = (one: LngLat, other: LngLat) => Math.abs(one[0] - other[0]) + Math.abs(one[1] - other[1]) < 1e-7;

const round = (value: number) => Math.round(value * 10) / 10;
