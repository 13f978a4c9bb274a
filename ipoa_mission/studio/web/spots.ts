// Home, start, goal and via points as buttons on the map: dragged by hand, or moved by the arrow keys.
import { Marker, type Map as MapLibre } from "maplibre-gl";
import type { Spot } from "./messages";
import { pathKey } from "./shapes";
import { blocking, drag, edit, endDrag, isNamed, isWritten, listen, set, studio, type Change, type LngLat } from "./store";

const SIGNS: Record<string, string> = { home: "H", start: "S", goal: "G", via: "", rally: "R" };
export const KEYS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const BESIDE: [number, number] = [-17, 15]; // home, which mostly lies below the start

interface Shown {
  spot: Spot;
  marker: Marker;
  button: HTMLButtonElement;
}

export function showSpots(map: MapLibre): void {
  const shown = new Map<string, Shown>();
  let held = "";
  const draw = () => {
    const spots = (studio.world?.spots ?? []).filter(spot => isWritten(spot.path));
    const keys = new Set(spots.map(spot => pathKey(spot.path)));
    for (const [key, { marker }] of shown) {
      if (!keys.has(key)) {
        marker.remove();
        shown.delete(key);
      }
    }
    for (const spot of spots) {
      const key = pathKey(spot.path);
      if (!shown.has(key)) shown.set(key, make(map, spot, () => shown.get(key)!, what => { held = what; }));
      const one = shown.get(key)!;
      one.spot = spot;
      if (held !== key) one.marker.setLngLat(spot.place as LngLat); // a hand knows better
      one.button.setAttribute("aria-label", `${spot.name}, ${spot.up.toFixed(0)} m above home; arrow keys move it`);
      one.button.title = `${spot.name}: ${spot.up.toFixed(1)} m above home, ${spot.above_ground.toFixed(1)} m above ground`;
    }
  };
  const mark = () => {
    const selected = studio.selected ? pathKey(studio.selected) : "";
    const refusals = blocking(studio);
    for (const [key, { button, spot }] of shown) {
      button.classList.toggle("chosen", key === selected);
      button.classList.toggle("lit", isNamed(spot.name, refusals));
    }
  };
  listen((now, before) => {
    if (now.world !== before.world || now.document !== before.document) draw();
    if (now.selected !== before.selected || now.world !== before.world || now.troubles !== before.troubles) mark();
  });
  draw();
}

function make(map: MapLibre, spot: Spot, self: () => Shown, hold: (key: string) => void): Shown {
  const kind = String(spot.path[0]);
  const button = document.createElement("button");
  button.type = "button";
  button.className = `spot ${kind}`;
  button.dataset.spot = pathKey(spot.path);
  button.textContent = SIGNS[kind] || `V${Number(spot.path[1] ?? 0) + 1}`;
  const marker = new Marker({ element: button, draggable: true, offset: kind === "home" ? BESIDE : [0, 0] }).setLngLat(spot.place as LngLat).addTo(map);
  const shift = (put: LngLat): Change => ({ op: "shift", path: self().spot.path, taken: self().spot.place as LngLat, put_down: put });
  marker.on("dragstart", () => hold(pathKey(self().spot.path)));
  marker.on("drag", () => drag([shift(marker.getLngLat().toArray() as LngLat)]));
  marker.on("dragend", () => {
    hold("");
    endDrag();
    edit(`${self().spot.name} moved`, shift(marker.getLngLat().toArray() as LngLat));
    set({ selected: self().spot.path });
  });
  button.addEventListener("click", event => {
    event.stopPropagation();
    set({ selected: self().spot.path });
  });
  button.addEventListener("keydown", event => {
    const step = KEYS[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const far = event.shiftKey ? 10 : 1;
    const [lng, lat] = self().spot.place as LngLat;
    const [wide, high] = studio.world!.degree_m as [number, number];
    edit(`${self().spot.name} moved`, shift([lng + (step[0] * far) / wide, lat + (step[1] * far) / high]));
  });
  return { spot, marker, button };
}
