// Handles of a survey on the map: its corners, the middles of its edges, all of it, the direction of its lines.
// Buttons like home and start: dragged, or moved by the arrow keys.
import { Marker, type Map as MapLibre } from "maplibre-gl";
import type { AreaRing } from "./messages";
import { draft } from "./map";
import { line, pathKey } from "./shapes";
import { KEYS } from "./spots";
import { drag, edit, endDrag, isSurvey, layoutOf, listen, set, studio, SURVEY, type Change, type LngLat, type Path } from "./store";

const MOST = 250; // corners that get a handle
const CLOSE = 80; // with more there are none on the edges
const FAR = 0.62; // of the area's size the handle of the direction is away from its middle

interface Handle {
  key: string;
  kind: "corner" | "edge" | "middle" | "direction";
  place: LngLat;
  sign: string;
  words: string;
  /** What it does where it is put; and what is drawn meanwhile. */
  change: (put: LngLat) => Change[];
  drawn: (put: LngLat) => LngLat[];
  label: string;
  take?: (() => void) | undefined;
  turn?: (degrees: number) => void;
  told?: (put: LngLat) => string;
}

interface Shown {
  handle: Handle;
  marker: Marker;
  button: HTMLButtonElement;
}

export function useSurveyHands(map: MapLibre): void {
  const shown = new Map<string, Shown>();
  let held = "";
  const draw = () => {
    const handles = handlesOf(), keys = new Set(handles.map(handle => handle.key));
    for (const [key, { marker }] of shown) {
      if (!keys.has(key)) {
        marker.remove();
        shown.delete(key);
      }
    }
    for (const handle of handles) {
      const one = shown.get(handle.key) ?? make(map, handle, () => shown.get(handle.key)!, key => { held = key; });
      shown.set(handle.key, one);
      one.handle = handle;
      if (held !== handle.key) one.marker.setLngLat(handle.place);
      one.button.textContent = handle.sign;
      one.button.title = handle.words;
      one.button.setAttribute("aria-label", handle.words);
    }
  };
  listen((now, before) => {
    const keys = ["area", "world", "document", "selected", "survey", "coarseSurvey", "dragSurvey", "space"] as const;
    if (keys.some(key => now[key] !== before[key])) draw();
  });
  draw();
}

function handlesOf(): Handle[] {
  const { area, world, selected } = studio;
  if (!area || !world || !isSurvey(studio) || studio.space || !area.rings.length) return [];
  const isChosen = selected !== null && pathKey(selected) === pathKey(SURVEY);
  const own = area.rings.filter(ring => ring.path !== null);
  const count = own.reduce((sum, ring) => sum + ring.places.length, 0);
  const corners = isChosen && count <= MOST ? own.flatMap(ring => [...cornersOf(ring), ...(count <= CLOSE ? edgesOf(ring) : [])]) : [];
  return [...directionOf(), ...(isChosen && own.length ? [middleOf(own)] : []), ...corners];
}

function cornersOf(ring: AreaRing): Handle[] {
  const path = ring.path!, places = ring.places as LngLat[], least = ring.what === "line" ? 2 : 3;
  return places.map((place, n): Handle => ({
    key: pathKey([...path, n]), kind: "corner", place, sign: "", label: `${ring.name}: corner moved`,
    words: `${ring.name}, corner ${n + 1}; arrow keys move it, Delete takes it out`,
    change: put => [{ op: "put_corner", path: [...path, n], place: put }],
    drawn: put => outline(ring, places.map((one, m) => (m === n ? put : one))),
    take: places.length > least ? () => edit(`${ring.name}: corner taken out`, { op: "take", path: [...path, n] }) : undefined,
  }));
}

function edgesOf(ring: AreaRing): Handle[] {
  const path = ring.path!, places = ring.places as LngLat[];
  const ends = ring.what === "line" ? places.slice(1) : [...places.slice(1), places[0]!];
  return ends.map((end, n): Handle => ({
    key: `${pathKey([...path, n])} edge`, kind: "edge", place: [(places[n]![0] + end[0]) / 2, (places[n]![1] + end[1]) / 2], sign: "+",
    label: `${ring.name}: corner added`, words: `${ring.name}, edge ${n + 1}: drag it, or press Enter, for a corner more`,
    change: put => [{ op: "add_corner", path: [...path, n + 1], place: put }],
    drawn: put => outline(ring, [...places.slice(0, n + 1), put, ...places.slice(n + 1)]),
  }));
}

const outline = (ring: AreaRing, places: LngLat[]): LngLat[] => (ring.what === "line" ? places : [...places, places[0]!]);

/** The handle that moves all that the scenario draws. */
function middleOf(own: AreaRing[]): Handle {
  const middle = middleOfAll(own), path: Path = ["survey", own[0]!.what === "line" ? "line" : "polygon"];
  return {
    key: "survey middle", kind: "middle", place: middle, sign: "✥", label: "area moved", words: "All of the area; arrow keys move it",
    change: put => [{ op: "shift", path, taken: middle, put_down: put }],
    drawn: put => outline(own[0]!, (own[0]!.places as LngLat[]).map(([lng, lat]): LngLat => [lng + put[0] - middle[0], lat + put[1] - middle[1]])),
  };
}

/** The direction of the lines, as an arm from the area's middle. */
function directionOf(): Handle[] {
  const rings = studio.area!.rings, layout = layoutOf(studio), given = studio.document?.scenario.survey?.direction_deg ?? "best";
  const degrees = typeof given === "number" ? given : layout?.degrees;
  if (degrees === undefined || rings[0]?.what === "line") return [];
  const [wide, high] = studio.world!.degree_m as [number, number], middle = middleOfAll(rings);
  const all = rings.flatMap(ring => ring.places as LngLat[]);
  const reach = FAR * Math.max(...all.map(([lng, lat]) => Math.hypot((lng - middle[0]) * wide, (lat - middle[1]) * high)));
  const turned = (put: LngLat) => {
    const angle = (Math.atan2((put[0] - middle[0]) * wide, (put[1] - middle[1]) * high) * 180) / Math.PI;
    return Math.round((angle + 360) % 180) % 180;
  };
  const at = (angle: number): LngLat => [middle[0] + (reach * Math.sin((angle * Math.PI) / 180)) / wide, middle[1] + (reach * Math.cos((angle * Math.PI) / 180)) / high];
  const put = (angle: number): Change => ({ op: "put", path: ["survey", "direction_deg"], value: angle });
  const how = given === "best" ? "the best" : typeof given === "number" ? "given" : String(given);
  return [{
    key: "survey direction", kind: "direction", place: at(degrees), sign: "⟳", label: "direction of the lines",
    words: `Direction of the lines: ${degrees.toFixed(0)}° from north, ${how}; arrow keys turn it`,
    change: there => [put(turned(there))], drawn: there => [at(turned(there) + 180), middle, at(turned(there))],
    told: there => `Lines at ${turned(there)}° from north`,
    turn: step => edit(`lines at ${(Math.round(degrees) + step + 180) % 180}°`, put((Math.round(degrees) + step + 180) % 180)),
  }];
}

function middleOfAll(rings: AreaRing[]): LngLat {
  const all = rings.flatMap(ring => ring.places as LngLat[]), lng = all.map(place => place[0]), lat = all.map(place => place[1]);
  return [(Math.min(...lng) + Math.max(...lng)) / 2, (Math.min(...lat) + Math.max(...lat)) / 2];
}

function make(map: MapLibre, handle: Handle, self: () => Shown, hold: (key: string) => void): Shown {
  const button = document.createElement("button");
  button.type = "button";
  button.className = `spot grip-${handle.kind}`;
  button.dataset.grip = handle.key;
  const marker = new Marker({ element: button, draggable: true }).setLngLat(handle.place).addTo(map);
  const put = () => marker.getLngLat().toArray() as LngLat;
  marker.on("dragstart", () => hold(self().handle.key));
  marker.on("drag", () => {
    draft(map, [line(self().handle.drawn(put()))]);
    drag(self().handle.change(put()));
    if (self().handle.told) set({ notice: self().handle.told!(put()) });
  });
  marker.on("dragend", () => {
    const { handle: one } = self(), there = put();
    hold("");
    draft(map, []);
    endDrag();
    if (one.told) set({ notice: "" });
    edit(one.label, ...one.change(there));
    if (one.kind !== "direction") set({ selected: SURVEY });
  });
  button.addEventListener("click", event => {
    event.stopPropagation();
    const { handle: one } = self();
    if (one.kind === "edge" && event.detail === 0) edit(one.label, ...one.change(one.place)); // by the keyboard
  });
  button.addEventListener("keydown", event => {
    const { handle: one } = self(), step = KEYS[event.key], far = event.shiftKey ? 10 : 1;
    if ((event.key === "Delete" || event.key === "Backspace") && one.take) one.take();
    else if (!step) return;
    else if (one.turn) one.turn((step[0] || step[1]) * far);
    else {
      const [wide, high] = studio.world!.degree_m as [number, number];
      edit(one.label, ...one.change([one.place[0] + (step[0] * far) / wide, one.place[1] + (step[1] * far) / high]));
    }
    event.preventDefault();
    event.stopPropagation();
  });
  return { handle, marker, button };
}
