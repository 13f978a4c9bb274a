// The map: MapLibre with a style of our own, made of nothing but the scenario; no tile is asked for anywhere.
import { Map as MapLibre, NavigationControl, ScaleControl, setWorkerUrl, type GeoJSONSource, type StyleSpecification } from "maplibre-gl";
import type { MapLine, Seen, Trouble, World } from "./messages";
import { color, onSchemeChange } from "./colors";
import { hillshade } from "./hillshade";
import { isDrawnBySoftware } from "./renderer";
import * as shapes from "./shapes";
import { drawSurvey, groundLayers, lineLayers, photoLayers, SURVEY_FLAT, SURVEY_KEYS, SURVEY_SOURCES, SURVEY_SPACE } from "./survey-map";
import { blocking, coarseOf, isMission, isNamed, isWritten, listen, proved, set, studio, type LngLat, type Studio } from "./store";
import { vectorLayers } from "./vector";

setWorkerUrl(new URL("map-worker.js", document.baseURI).href);

const SOURCES = ["ground", "bodies", "lit", "fences", "bounds", "others", "deviation", "homeward", "path", "flown", "ribbon", "flown-ribbon", "kept", "items", "here", "posts", "pillar", "vehicle", "found", "draft", ...SURVEY_SOURCES] as const;
type SourceName = (typeof SOURCES)[number];
const UNHEARD_S = 2.5; // a vehicle that is watched says where it is many times in so long
const EMPTY = shapes.collection([]);
const FLAT = ["ground", "roofs", "roof-lines", "wires", "deviation", "arrows", "homeward", "items", ...SURVEY_FLAT];
const SPACE = [...SURVEY_SPACE, "ground-space", "roofs-space", "zones-space", "posts", "ribbon", "flown-ribbon", "pillar"];

export function makeMap(container: HTMLElement): MapLibre {
  const map = new MapLibre({
    container, style: style(), center: [0, 0], zoom: 1, maxZoom: 22, maxPitch: 75, attributionControl: false,
    dragRotate: true, fadeDuration: 0, canvasContextAttributes: { antialias: !isDrawnBySoftware() },
  });
  map.on("error", event => {
    if ((event as { sourceId?: string }).sourceId === "tiles") set({ notice: "Some of the map's tiles could not be had." });
    else console.error(event.error.message);
  });
  map.addControl(new NavigationControl({ visualizePitch: true }), "top-right");
  map.addControl(new ScaleControl({ maxWidth: 120 }), "bottom-left");
  shown = map;
  map.on("load", () => {
    addImages(map);
    drawAll(map, studio);
    if (studio.found) showFound(map, studio);
    listen((now, before) => update(map, now, before));
  });
  onSchemeChange(() => {
    map.setStyle(style(), { diff: false });
    map.once("style.load", () => { addImages(map); drawAll(map, studio); drawFound(map, studio); });
  });
  return map;
}

export function fit(map: MapLibre, world: World, animate = true): void {
  const items = isMission(studio) ? studio.mission?.items.flatMap(item => (item.place ? [item.place] : [])) ?? [] : [];
  const corners = studio.area?.rings.flatMap(ring => ring.places) ?? [];
  const places = [...world.spots.map(spot => spot.place), ...items, ...corners] as [number, number][];
  const [west, south, east, north] = isMission(studio) ? [-180, -85, 180, 85] as const : world.box as [number, number, number, number];
  const lng = places.map(place => place[0]), lat = places.map(place => place[1]);
  const near = [Math.min(...lng), Math.min(...lat), Math.max(...lng), Math.max(...lat)] as const;
  const room = 0.25 * Math.max(near[2] - near[0], near[3] - near[1], 0.0003);
  map.fitBounds(
    [[Math.max(west, near[0] - room), Math.max(south, near[1] - room)], [Math.min(east, near[2] + room), Math.min(north, near[3] + room)]],
    { padding: studio.space ? { top: 150, bottom: 30, left: 50, right: 50 } : 30, animate: animate && !matchMedia("(prefers-reduced-motion: reduce)").matches, pitch: studio.space ? 58 : 0 },
  );
}

let shown: MapLibre | null = null;

/** Go to what a refusal names. */
export function showNamed(trouble: Trouble): void {
  const world = studio.world;
  if (!shown || !world) return;
  const rings = world.bodies.filter(body => isNamed(body.name, [trouble])).flatMap(body => body.rings[0] ?? []);
  const areas = (studio.area?.rings ?? []).filter(ring => isNamed(`${ring.name}:`, [trouble]) || isNamed(`${ring.name},`, [trouble]));
  const places = [...rings, ...areas.flatMap(ring => ring.places), ...world.spots.filter(spot => isNamed(spot.name, [trouble])).map(spot => spot.place)] as [number, number][];
  if (!places.length) return fit(shown, world);
  const lng = places.map(place => place[0]), lat = places.map(place => place[1]);
  shown.fitBounds([[Math.min(...lng), Math.min(...lat)], [Math.max(...lng), Math.max(...lat)]], { padding: 90, maxZoom: 19, animate: false });
}

/** Have a place in sight; a map that has it stays where it is. */
export function bringInSight(place: LngLat): void {
  if (shown && !shown.getBounds().contains(place)) shown.panTo(place, { animate: false });
}

/** Fill in what is drawn while the user draws. */
export function draft(map: MapLibre, features: GeoJSON.Feature[]): void {
  fill(map, "draft", features);
}

function update(map: MapLibre, now: Studio, before: Studio): void {
  if (now.world !== before.world && now.world) {
    drawWorld(map, now.world);
    if (!before.world || wentAway(map, now.world, before.world)) fit(map, now.world, false);
  }
  if (now.troubles !== before.troubles || now.world !== before.world) drawLit(map, now);
  if (now.mission && !before.mission && now.world) fit(map, now.world, false);
  if (SURVEY_KEYS.some(key => now[key] !== before[key])) drawSurvey(now, (name, features) => fill(map, name, features));
  if (["plan", "survey", "part", "dragSurvey", "sketch", "drag", "document", "world", "mission"].some(key => now[key as keyof Studio] !== before[key as keyof Studio])) drawPath(map, now);
  if (now.found !== before.found) showFound(map, now);
  if (now.tiles !== before.tiles || now.picture !== before.picture) showPicture(map, now);
  if (now.item !== before.item) drawItems(map, now);
  if (now.flown !== before.flown || now.replay !== before.replay) drawFlown(map, now);
  if (now.candidates !== before.candidates) drawKept(map, now);
  if (now.at !== before.at || now.part !== before.part || now.survey !== before.survey || now.plan !== before.plan || now.document !== before.document || now.homeward !== before.homeward) drawHomeward(map, now);
  if (now.at !== before.at || now.part !== before.part || now.survey !== before.survey || now.plan !== before.plan || now.document !== before.document || now.space !== before.space) drawHere(map, now);
  if (now.space !== before.space) {
    showSpace(map, now.space);
    showPicture(map, now);
    map.easeTo({ pitch: now.space ? 58 : 0, bearing: now.space ? map.getBearing() || -18 : 0, duration: 500 });
    drawPath(map, now);
  }
}

function drawFound(map: MapLibre, { found }: Studio): void {
  fill(map, "found", found ? [{ type: "Feature", properties: {}, geometry: { type: "Point", coordinates: found.place as LngLat } }] : []);
}

/** The place that was looked for, and how far it is from home. */
function showFound(map: MapLibre, now: Studio): void {
  const { found, world } = now;
  drawFound(map, now);
  if (!found) return;
  map.easeTo({ center: found.place as LngLat, zoom: Math.max(map.getZoom(), 15), animate: false });
  const home = world?.spots.find(spot => spot.name === "home")?.place;
  const away = home && world ? Math.hypot((found.place[0]! - home[0]!) * world.degree_m[0]!, (found.place[1]! - home[1]!) * world.degree_m[1]!) : null;
  set({ notice: `${found.words}: ${found.place[1]!.toFixed(6)}, ${found.place[0]!.toFixed(6)}${away === null ? "" : `, ${away < 10_000 ? `${away.toFixed(0)} m` : `${(away / 1000).toFixed(0)} km`} from home`}` });
}

/** Whether a place of the flight has moved out of sight, as by a file that was dropped. */
function wentAway(map: MapLibre, now: World, before: World): boolean {
  const known = new Set(before.spots.map(spot => String(spot.place)));
  const moved = now.spots.filter(spot => isWritten(spot.path) && !known.has(String(spot.place)));
  return moved.some(spot => !map.getBounds().contains(spot.place as [number, number]));
}

/** What stands in the way of a plan, by name. */
function drawLit(map: MapLibre, now: Studio): void {
  const refusals = blocking(now), bodies = refusals.length && now.world ? now.world.bodies : [];
  fill(map, "lit", bodies.filter(body => isNamed(body.name, refusals)).map(body => shapes.line(body.rings[0])));
}

function drawAll(map: MapLibre, now: Studio): void {
  filled.clear();
  if (now.world) {
    drawWorld(map, now.world);
    if (map.getZoom() < 3) fit(map, now.world, false);
  }
  drawPath(map, now);
  drawSurvey(now, (name, features) => fill(map, name, features));
  drawFlown(map, now);
  drawKept(map, now);
  drawHere(map, now);
  drawHomeward(map, now);
  drawLit(map, now);
  showSpace(map, now.space);
  showPicture(map, now);
}

function drawWorld(map: MapLibre, world: World): void {
  fill(map, "ground", shapes.ground(world));
  showHillshade(map, world);
  fill(map, "bodies", shapes.bodies(world));
  fill(map, "posts", world.spots.flatMap(spot => shapes.pillar(spot.place as LngLat, spot.up - spot.above_ground - shapes.lowest(world), spot.up - shapes.lowest(world))));
  fill(map, "fences", shapes.fences(world));
  fill(map, "bounds", shapes.bounds(world));
}

/** Light on the ground; it is made anew with the world, and goes with the ground's colors. */
function showHillshade(map: MapLibre, world: World): void {
  if (map.getLayer("hillshade")) map.removeLayer("hillshade");
  if (map.getSource("hillshade")) map.removeSource("hillshade");
  const shade = hillshade(world);
  if (!shade) return;
  map.addSource("hillshade", { type: "canvas", canvas: shade.canvas, coordinates: shade.corners, animate: false });
  const visibility = studio.space || (studio.tiles && studio.picture) ? "none" : "visible";
  map.addLayer({ id: "hillshade", type: "raster", source: "hillshade", layout: { visibility }, paint: { "raster-fade-duration": 0, "raster-opacity": 0.55 } }, "contours");
}

/** The proved path if there is one of what is here now, else the coarse one, dashed. */
function drawPath(map: MapLibre, now: Studio): void {
  const plan = now.dragSurvey ? null : proved(now), coarse = now.drag ?? (plan ? null : coarseOf(now));
  const course: MapLine | undefined = coarse ? coarse.line : plan?.course.line;
  const untimed = course || !isMission(now) ? [] : placesOf(now).map(item => item.place);
  const turns = coarse ? null : plan?.course.returns_at ?? null; // what comes then is the way home
  fill(map, "path", course && turns !== null ? [shapes.line(course.points.slice(0, turns + 1), { coarse: false }), shapes.line(course.points.slice(turns), { coarse: false, home: true })]
    : course ? [shapes.line(course.points, { coarse: coarse !== null, is_proved: coarse?.is_proved ?? true })]
    : untimed.length > 1 ? [shapes.line(untimed, { coarse: true, is_proved: true })] : []);
  fill(map, "others", coarse ? coarse.others.map(other => shapes.line(other.points)) : []);
  drawItems(map, now);
  fill(map, "deviation", plan && !coarse ? shapes.deviationBound(plan) : []);
  fill(map, "ribbon", course && now.space && now.world ? shapes.ribbon(course, shapes.lowest(now.world), 2.2, 1.4, !coarse ? "proved" : coarse.is_proved ? "coarse" : "broken") : []);
}

/** Where the items lie that have a place, by their numbers; the chosen one stands out. */
function drawItems(map: MapLibre, now: Studio): void {
  const stops = isMission(now) ? placesOf(now) : now.drag || now.dragSurvey ? [] : proved(now)?.stops ?? [];
  fill(map, "items", stops.filter(stop => stop.place).map(stop => {
    const name = `${stop.seq}${stop.seq === now.item ? "!" : ""}`, icon = `item${name}`;
    if (!map.hasImage(icon)) map.addImage(icon, numbered(name), { pixelRatio: 2 });
    return { type: "Feature", properties: { seq: stop.seq, icon, rank: name.endsWith("!") ? 0 : 1, hidden: isUnder(now, stop.place as LngLat) }, geometry: { type: "Point", coordinates: stop.place as [number, number] } };
  }));
}

/** Whether the button of a place of the scenario lies over a place: an item's number is drawn beside it. */
function isUnder({ world }: Studio, [lng, lat]: LngLat): boolean {
  const [wide, high] = world?.degree_m ?? [1, 1];
  return (world?.spots ?? []).some(({ path, place }) => isWritten(path) && Math.hypot((place[0]! - lng) * wide!, (place[1]! - lat) * high!) < 2);
}

/** The items of an open mission that lie somewhere. */
export function placesOf(now: Studio): { seq: number; place: LngLat }[] {
  return now.mission?.items.flatMap(item => (item.place ? [{ seq: item.seq, place: item.place as LngLat }] : [])) ?? [];
}

/** Where the vehicle was, as a way that ends where it was not heard and begins again behind that. */
function heardWays(flown: Seen[]): LngLat[][] {
  const ways: LngLat[][] = [];
  flown.forEach((seen, n) => {
    if (n === 0 || seen.time_s - flown[n - 1]!.time_s > UNHEARD_S) ways.push([]);
    ways.at(-1)!.push(seen.place as LngLat);
  });
  return ways;
}

function drawFlown(map: MapLibre, now: Studio): void {
  const points = now.replay?.line.points ?? now.flown.map(seen => seen.place), up = now.replay?.line.up ?? now.flown.map(seen => seen.up);
  const ways = now.replay ? [points] : heardWays(now.flown);
  fill(map, "flown", ways.filter(way => way.length > 1).map(way => shapes.line(way)));
  const last = now.flight?.phase === "flying" ? points.at(-1) : undefined;
  fill(map, "vehicle", last ? [{ type: "Feature", properties: {}, geometry: { type: "Point", coordinates: last as [number, number] } }] : []);
  const course = { points, up } as MapLine;
  fill(map, "flown-ribbon", now.space && now.world && points.length > 1 ? shapes.ribbon(course, shapes.lowest(now.world), 1.4, 1) : []);
}

/** Plans that were kept, each in its own color. */
function drawKept(map: MapLibre, now: Studio): void {
  const colors = ["focus", "good", "flown", "legs"];
  fill(map, "kept", now.candidates.map((kept, n) => shapes.line(kept.plan.course.line.points, { color: color(colors[n % 4]!), name: kept.name })));
}

/** The ways home, and that of the moment that the slider stands at. */
function drawHomeward(map: MapLibre, now: Studio): void {
  const plan = proved(now), ways = now.homeward ? plan?.homeward ?? [] : [];
  const time = plan?.course.times[now.at] ?? 0, chosen = ways.findLastIndex(way => way.from_s <= time + 0.01);
  fill(map, "homeward", ways.map((way, n) => shapes.line(way.line.points, { clear: way.clear, now: n === chosen })));
}

/** The moment that the slider stands at: a dot from above, a pillar in space. */
function drawHere(map: MapLibre, now: Studio): void {
  const plan = proved(now);
  const place = plan?.course.line.points[now.at], up = plan?.course.line.up[now.at];
  if (!place || up === undefined || !now.world) {
    fill(map, "here", []);
    return fill(map, "pillar", []);
  }
  const ground = plan!.course.ground[now.at]! - shapes.lowest(now.world);
  fill(map, "here", [{ type: "Feature", properties: {}, geometry: { type: "Point", coordinates: place as [number, number] } }]);
  fill(map, "pillar", now.space ? shapes.pillar(place as [number, number], Math.max(0, ground), up - shapes.lowest(now.world)) : []);
}

function showSpace(map: MapLibre, space: boolean): void {
  showLayers(map, studio);
  for (const name of ["path", "path-home", "coarse"]) map.setPaintProperty(name, "line-opacity", space ? 0.25 : 1);
}

/** The tiles below everything, in place of the ground's own colors; what stands on them is seen through. */
function showPicture(map: MapLibre, now: Studio): void {
  const tiles = now.tiles;
  if (tiles && !map.getSource("tiles")) {
    const zooms = { tiles: [tiles.address], maxzoom: tiles.max_zoom };
    map.addSource("tiles", tiles.vector ? { type: "vector", ...zooms } : { type: "raster", tileSize: 256, ...zooms });
    const layers = tiles.vector ? vectorLayers() : [{ id: "tiles", type: "raster" as const, source: "tiles", paint: { "raster-fade-duration": 0 } }];
    for (const layer of layers) map.addLayer(layer, "ground");
  }
  const shown = tiles !== null && now.picture;
  for (const id of map.getLayersOrder()) if (id.startsWith("tiles")) map.setLayoutProperty(id, "visibility", shown ? "visible" : "none");
  showLayers(map, now, "ground");
  if (map.getLayer("hillshade")) map.setLayoutProperty("hillshade", "visibility", now.space || shown ? "none" : "visible");
  map.setPaintProperty("roofs", "fill-opacity", seenThrough(shown ? 0.55 : 1));
}

/** How opaque roofs are; trees and wires are less. */
const seenThrough = (roofs: number): any => ["match", ["get", "look"], "tree", 0.45, "wire", 0.2, roofs];

const filled = new Set<string>();

/** What a source holds; layers of one that holds nothing are not drawn: each costs a pass over all of the map. */
function fill(map: MapLibre, name: SourceName, features: GeoJSON.Feature[]): void {
  if (!features.length && !filled.has(name)) return;
  (map.getSource(name) as GeoJSONSource | undefined)?.setData(shapes.collection(features));
  if (features.length > 0 === filled.has(name)) return;
  if (features.length) filled.add(name);
  else filled.delete(name);
  showLayers(map, studio, name);
}

/** Which layers are drawn: all, or those of one source. */
function showLayers(map: MapLibre, now: Studio, only?: SourceName): void {
  const isCovered = now.tiles !== null && now.picture;
  for (const id of map.getLayersOrder()) {
    const source = map.getLayer(id)!.source;
    if (!SOURCES.some(name => name === source) || (only && source !== only)) continue;
    const isShown = filled.has(source) && !(now.space ? FLAT : SPACE).includes(id) && !(id === "ground" && isCovered);
    map.setLayoutProperty(id, "visibility", isShown ? "visible" : "none");
  }
}

function addImages(map: MapLibre): void {
  map.addImage("hatch", hatch());
  map.addImage("arrow", drawn(20, pen => {
    pen.fillStyle = color("planned");
    pen.moveTo(3, 3);
    pen.lineTo(18, 10);
    pen.lineTo(3, 17);
    pen.fill();
  }), { pixelRatio: 2 });
}

/** An item's number in a small disk; one with "!" behind it is the chosen one. */
function numbered(seq: string): ImageData {
  const chosen = seq.endsWith("!");
  return drawn(32, pen => {
    pen.fillStyle = color(chosen ? "focus" : "card");
    pen.strokeStyle = color("planned");
    pen.lineWidth = 3;
    pen.arc(16, 16, 14, 0, 7);
    pen.fill();
    pen.stroke();
    pen.fillStyle = chosen ? "#1c2630" : color("ink");
    pen.font = "600 16px sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(seq.replace("!", ""), 16, 17);
  });
}

function drawn(size: number, draw: (pen: CanvasRenderingContext2D) => void): ImageData {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const pen = canvas.getContext("2d")!;
  draw(pen);
  return pen.getImageData(0, 0, size, size);
}

/** Strokes across what may not be entered. */
function hatch(): ImageData {
  const size = 12, canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  const pen = canvas.getContext("2d")!;
  pen.strokeStyle = color("bad");
  pen.lineWidth = 1.2;
  pen.globalAlpha = 0.75;
  for (const shift of [-size, 0, size]) {
    pen.moveTo(shift, size);
    pen.lineTo(shift + size, 0);
  }
  pen.stroke();
  return pen.getImageData(0, 0, size, size);
}

function style(): StyleSpecification {
  const ramp = (low: string, high: string): any => ["interpolate", ["linear"], ["get", "share"], 0, color(low), 1, color(high)];
  const solid: any = ["==", ["get", "solid"], true], zone: any = ["all", ["!=", ["get", "solid"], true], ["!=", ["get", "doubt"], true]], doubt: any = ["==", ["get", "doubt"], true];
  const dash = [2.2, 1.6];
  return {
    version: 8,
    sources: Object.fromEntries(SOURCES.map(name => [name, { type: "geojson", data: EMPTY, tolerance: 0, maxzoom: 19 }])),
    layers: [
      { id: "paper", type: "background", paint: { "background-color": color("paper") } },
      { id: "ground", type: "fill", source: "ground", paint: { "fill-color": ramp("low-ground", "high-ground"), "fill-antialias": false } },
      { id: "contours", type: "line", source: "ground", paint: { "line-color": color("contour"), "line-width": 0.6, "line-opacity": 0.55 } },
      { id: "ground-space", type: "fill-extrusion", source: "ground", layout: { visibility: "none" }, paint: { "fill-extrusion-color": ramp("low-ground", "high-ground"), "fill-extrusion-height": ["get", "rise"] } },
      ...groundLayers(),
      { id: "bounds", type: "line", source: "bounds", paint: { "line-color": color("quiet"), "line-width": 1, "line-dasharray": [4, 4] } },
      { id: "deviation", type: "fill", source: "deviation", paint: { "fill-color": color("planned"), "fill-opacity": 0.2 } },
      { id: "roofs", type: "fill", source: "bodies", filter: solid, paint: { "fill-color": ["match", ["get", "look"], "tree", color("good"), "wire", color("amber"), ramp("low-roof", "high-roof")], "fill-opacity": seenThrough(1) } },
      { id: "roof-lines", type: "line", source: "bodies", filter: ["all", solid, ["!=", ["get", "look"], "wire"]], paint: { "line-color": color("edge"), "line-width": 0.8 } },
      { id: "wires", type: "line", source: "bodies", filter: ["==", ["get", "look"], "wire"], paint: { "line-color": color("amber"), "line-width": 1.4, "line-dasharray": [5, 2, 1, 2] } },
      { id: "zones", type: "fill", source: "bodies", filter: zone, paint: { "fill-pattern": "hatch" } },
      { id: "zone-lines", type: "line", source: "bodies", filter: zone, paint: { "line-color": color("bad"), "line-width": 1.4 } },
      { id: "doubts", type: "fill", source: "bodies", filter: doubt, paint: { "fill-color": color("amber"), "fill-opacity": 0.16 } },
      { id: "doubt-lines", type: "line", source: "bodies", filter: doubt, paint: { "line-color": color("amber"), "line-width": 1.4, "line-dasharray": [3, 2] } },
      { id: "lit", type: "line", source: "lit", paint: { "line-color": color("focus"), "line-width": 5, "line-opacity": 0.9 } },
      { id: "keep-out", type: "fill", source: "fences", filter: ["!", ["get", "inclusion"]], paint: { "fill-pattern": "hatch" } },
      { id: "fence-lines", type: "line", source: "fences", paint: { "line-color": ["case", ["get", "inclusion"], color("good"), color("bad")], "line-width": 2 } },
      ...lineLayers(),
      { id: "others", type: "line", source: "others", paint: { "line-color": color("legs"), "line-width": 1.4, "line-dasharray": [1.5, 2], "line-opacity": 0.8 } },
      { id: "kept", type: "line", source: "kept", paint: { "line-color": ["get", "color"], "line-width": 2.4, "line-dasharray": [4, 1.5] } },
      { id: "path-home", type: "line", source: "path", filter: ["==", ["get", "home"], true], layout: { "line-cap": "round", "line-join": "round" }, paint: { "line-color": color("planned"), "line-width": 3, "line-dasharray": [0.1, 2] } },
      { id: "path", type: "line", source: "path", filter: ["all", ["!", ["get", "coarse"]], ["!=", ["get", "home"], true]], layout: { "line-cap": "round", "line-join": "round" }, paint: { "line-color": color("planned"), "line-width": 3.4 } },
      { id: "arrows", type: "symbol", source: "path", filter: ["!", ["get", "coarse"]], layout: { "symbol-placement": "line", "symbol-spacing": 90, "icon-image": "arrow", "icon-size": 1.3, "icon-allow-overlap": true } },
      ...photoLayers(),
      { id: "homeward", type: "line", source: "homeward", layout: { "line-sort-key": ["case", ["get", "now"], 1, 0] }, paint: { "line-color": ["case", ["get", "clear"], color("good"), color("bad")], "line-width": ["case", ["get", "now"], 3.2, 1], "line-opacity": ["case", ["get", "now"], 1, 0.3] } },
      { id: "coarse", type: "line", source: "path", filter: ["get", "coarse"], layout: { "line-join": "round" }, paint: { "line-color": ["case", ["get", "is_proved"], color("planned"), color("bad")], "line-width": 3, "line-dasharray": dash } },
      { id: "flown", type: "line", source: "flown", layout: { "line-cap": "round" }, paint: { "line-color": color("flown"), "line-width": 2.2 } },
      { id: "roofs-space", type: "fill-extrusion", source: "bodies", filter: solid, layout: { visibility: "none" }, paint: { "fill-extrusion-color": ramp("low-roof", "high-roof"), "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"] } },
      { id: "zones-space", type: "fill-extrusion", source: "bodies", filter: zone, layout: { visibility: "none" }, paint: { "fill-extrusion-color": color("bad"), "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"], "fill-extrusion-opacity": 0.18 } },
      { id: "ribbon", type: "fill-extrusion", source: "ribbon", layout: { visibility: "none" }, paint: { "fill-extrusion-color": ["match", ["get", "look"], "coarse", color("quiet"), "broken", color("bad"), color("planned")], "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"], "fill-extrusion-vertical-gradient": false } },
      { id: "flown-ribbon", type: "fill-extrusion", source: "flown-ribbon", layout: { visibility: "none" }, paint: { "fill-extrusion-color": color("flown"), "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"], "fill-extrusion-vertical-gradient": false } },
      { id: "posts", type: "fill-extrusion", source: "posts", layout: { visibility: "none" }, paint: { "fill-extrusion-color": color("ink"), "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"], "fill-extrusion-opacity": 0.55 } },
      { id: "pillar", type: "fill-extrusion", source: "pillar", layout: { visibility: "none" }, paint: { "fill-extrusion-color": color("focus"), "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"] } },
      { id: "here", type: "circle", source: "here", paint: { "circle-color": color("focus"), "circle-stroke-color": color("ink"), "circle-stroke-width": 2, "circle-radius": 6 } },
      { id: "items", type: "symbol", source: "items", layout: { "icon-image": ["get", "icon"], "symbol-sort-key": ["get", "rank"], "icon-offset": ["case", ["get", "hidden"], ["literal", [20, 16]], ["literal", [0, 0]]] } },
      { id: "vehicle", type: "circle", source: "vehicle", paint: { "circle-color": color("flown"), "circle-stroke-color": color("card"), "circle-stroke-width": 2.5, "circle-radius": 8 } },
      { id: "found", type: "circle", source: "found", paint: { "circle-color": "transparent", "circle-stroke-color": color("bad"), "circle-stroke-width": 3, "circle-radius": 11 } },
      { id: "draft-fill", type: "fill", source: "draft", filter: ["==", ["geometry-type"], "Polygon"], paint: { "fill-color": color("focus"), "fill-opacity": 0.25 } },
      { id: "draft-closing", type: "line", source: "draft", filter: ["==", ["get", "closing"], true], paint: { "line-color": color("focus"), "line-width": 1.6, "line-dasharray": [2, 2] } },
      { id: "draft", type: "line", source: "draft", filter: ["!=", ["get", "closing"], true], paint: { "line-color": color("focus"), "line-width": 2 } },
      { id: "draft-points", type: "circle", source: "draft", filter: ["==", ["geometry-type"], "Point"], paint: { "circle-color": color("card"), "circle-stroke-color": color("focus"), "circle-stroke-width": 2, "circle-radius": 5 } },
    ],
  };
}
