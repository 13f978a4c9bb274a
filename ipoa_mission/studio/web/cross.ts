// A crosshair on the map that the arrow keys move: all that hands do with a pointer is done with it by keyboard.
import { Marker, type Map as MapLibre } from "maplibre-gl";
import { bringInSight, placesOf } from "./map";
import { showPlace } from "./pointer";
import { pathKey } from "./shapes";
import { KEYS } from "./spots";
import { isMission, listen, set, studio, type LngLat } from "./store";

const WIDE = 300; // meters of the map's width up to ten times which a step is one meter
const HELP = "Arrow keys move the crosshair, with Shift ten times as far; Enter ";
const TAIL = "; Esc leaves.";

/** What the hands do where the crosshair is. */
export interface Hand {
  /** Enter: what was done, in words. */
  press: (at: LngLat) => string;
  /** It has moved. */
  over: (at: LngLat) => void;
  /** Backspace: what was taken back, in words; null if there is nothing that is being drawn. */
  back: () => string | null;
  /** Escape: whether something was let go, so that the crosshair stays. */
  letGo: () => boolean;
}

export function useCross(map: MapLibre, hand: Hand): { isShown: () => boolean } {
  const element = document.createElement("div"), canvas = map.getCanvas();
  element.className = "cross";
  element.setAttribute("aria-hidden", "true");
  const marker = new Marker({ element });
  let at: LngLat | null = null, byKeys = false;

  const show = (place: LngLat, said = "") => {
    at = place;
    marker.setLngLat(place).addTo(map);
    bringInSight(place);
    hand.over(place);
    set({ spoken: `${said}${showPlace(map, place)}` });
  };
  const begin = () => {
    canvas.setAttribute("role", "application"); // arrow keys are meant for it, not for the screen reader
    canvas.focus({ preventScroll: true });
    set({ notice: HELP + DOES[studio.tool] + TAIL });
    show(at ?? chosenPlace() ?? onTheMeter(map.getCenter().toArray() as LngLat), `${HELP}${DOES[studio.tool]}${TAIL} `);
  };
  const hide = () => {
    if (!at) return;
    at = null;
    marker.remove();
    canvas.setAttribute("role", "region");
  };

  addEventListener("pointerdown", () => { byKeys = false; }, true);
  addEventListener("keydown", event => {
    byKeys = true;
    const inField = event.target instanceof HTMLElement && event.target.matches("input, textarea, select");
    const free = event.target === canvas || event.target === document.body, step = KEYS[event.key];
    if (inField || event.ctrlKey || event.metaKey || event.altKey || !studio.world) return;
    if (event.key === "c" || (free && !at && step && studio.tool !== "select")) {
      begin();
    } else if (!free || !at) {
      return;
    } else if (step) {
      const [wide, high] = studio.world.degree_m as [number, number], far = (event.shiftKey ? 10 : 1) * unit(map, wide);
      show([at[0] + (step[0] * far) / wide, at[1] + (step[1] * far) / high]);
    } else if (event.key === "Enter") {
      const said = hand.press(at);
      set({ spoken: said });
    } else if (event.key === "Backspace") {
      const said = hand.back();
      if (said === null) return;
      set({ spoken: said });
      hand.over(at);
    } else if (event.key === "Escape") {
      if (!hand.letGo()) {
        hide();
        set({ spoken: "The crosshair is gone.", notice: "" });
        return; // the tool is put away as well
      }
      set({ spoken: "Let go where it was." });
    } else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);
  canvas.addEventListener("pointerdown", hide);
  listen((now, before) => {
    if (now.tool === before.tool) return;
    if (now.tool === "select") hide();
    else if (byKeys) begin();
  });
  return { isShown: () => at !== null };
}

/** The nearest place that lies whole meters from home. */
function onTheMeter([lng, lat]: LngLat): LngLat {
  const home = studio.world!.spots.find(spot => spot.name === "home")?.place, [wide, high] = studio.world!.degree_m as [number, number];
  if (!home) return [lng, lat];
  return [home[0]! + Math.round((lng - home[0]!) * wide) / wide, home[1]! + Math.round((lat - home[1]!) * high) / high];
}

/** Where what is chosen lies, if it lies at a point. */
function chosenPlace(): LngLat | undefined {
  if (studio.tool !== "select") return undefined;
  const key = studio.selected ? pathKey(studio.selected) : "", spot = studio.world?.spots.find(one => pathKey(one.path) === key);
  return (isMission(studio) ? placesOf(studio).find(one => one.seq === studio.item)?.place : spot?.place) as LngLat | undefined;
}

/** What Enter does with each tool. */
const DOES: Record<string, string> = {
  select: "takes hold of what is there, and puts it down", measure: "measures from there", waypoint: "puts a waypoint there", via: "puts a via point there",
  cylinder: "puts a mast there", rally: "puts a rally point there",
  ...Object.fromEntries(["polygon", "keep-out", "keep-in", "area", "hole"].map(tool => [tool, "puts a corner there, and twice on one place closes it; Backspace takes the last back"])),
  corridor: "puts a corner there, and twice on one place ends it; Backspace takes the last back",
};

/** How far an arrow key goes [m]: one meter on a map of a few hundred, ten on one of some kilometers. */
function unit(map: MapLibre, degree: number): number {
  const bounds = map.getBounds(), across = (bounds.getEast() - bounds.getWest()) * degree;
  return 10 ** Math.max(0, Math.floor(Math.log10(across / WIDE)));
}
