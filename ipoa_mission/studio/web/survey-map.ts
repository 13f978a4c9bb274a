// A survey on the map: its area, the lines over it, photos, what is seen and what is not.
import type { LayerSpecification } from "maplibre-gl";
import { color } from "./colors";
import type { SurveyLayout } from "./messages";
import * as shapes from "./shapes";
import { coarseSurveyOf, layoutOf, photoAt, proved, surveyed, type LngLat, type Studio } from "./store";

export const SURVEY_SOURCES = ["area", "seen", "gaps", "kept-out", "survey-lines", "survey-ways", "photos", "footprint", "survey-ribbon", "looked-at"] as const;
export const SURVEY_FLAT = ["area-fill", "area-lines", "seen", "gaps", "gap-lines", "kept-out", "survey-lines", "survey-coarse", "survey-ways", "photos", "footprint", "looked-at"];
export const SURVEY_SPACE = ["survey-ribbon"];
const HUES = ["legs", "good", "flown", "focus"]; // of flights that are not chosen
const WIDE = 1.4, HIGH = 1; // of a line in space [m]

type Fill = (name: (typeof SURVEY_SOURCES)[number], features: GeoJSON.Feature[]) => void;

/** The color of a survey's flight on the map and in the list, where it is not the chosen one. */
export const hueOf = (flight: number): string => color(HUES[flight % HUES.length]!);

/** All that lies below the buildings. */
export function groundLayers(): LayerSpecification[] {
  return [
    { id: "area-fill", type: "fill", source: "area", filter: ["==", ["geometry-type"], "Polygon"], paint: { "fill-color": color("focus"), "fill-opacity": 0.07 } },
    { id: "seen", type: "fill", source: "seen", paint: { "fill-color": color("planned"), "fill-opacity": 0.14, "fill-antialias": false } },
    { id: "kept-out", type: "fill", source: "kept-out", paint: { "fill-color": color("quiet"), "fill-opacity": 0.28 } },
    { id: "gaps", type: "fill", source: "gaps", paint: { "fill-color": color("bad"), "fill-opacity": 0.6 } },
    { id: "gap-lines", type: "line", source: "gaps", paint: { "line-color": color("bad"), "line-width": 2.5 } },
  ] as LayerSpecification[];
}

/** All that lies above them. */
export function lineLayers(): LayerSpecification[] {
  const dash = [2.2, 1.6], coarse: any = ["get", "coarse"], lit: any = ["==", ["get", "lit"], true];
  return [
    { id: "area-lines", type: "line", source: "area", paint: { "line-color": ["case", lit, color("bad"), color("focus")], "line-width": ["case", lit, 4, 2] } },
    { id: "footprint", type: "fill", source: "footprint", paint: { "fill-color": color("focus"), "fill-opacity": 0.3, "fill-outline-color": color("ink") } },
    { id: "survey-ways", type: "line", source: "survey-ways", paint: { "line-color": color("quiet"), "line-width": 1.2, "line-dasharray": [1.5, 2] } },
    { id: "survey-lines", type: "line", source: "survey-lines", filter: ["!", coarse], layout: { "line-cap": "round" }, paint: { "line-color": ["get", "color"], "line-width": 2.4 } },
    { id: "survey-coarse", type: "line", source: "survey-lines", filter: coarse, paint: { "line-color": color("planned"), "line-width": 2.4, "line-dasharray": dash } },
    { id: "survey-ribbon", type: "fill-extrusion", source: "survey-ribbon", layout: { visibility: "none" }, paint: { "fill-extrusion-color": ["get", "color"], "fill-extrusion-base": ["get", "from"], "fill-extrusion-height": ["get", "to"], "fill-extrusion-vertical-gradient": false } },
  ] as LayerSpecification[];
}

/** All that lies above the path. */
export function photoLayers(): LayerSpecification[] {
  return [
    { id: "photos", type: "circle", source: "photos", minzoom: 14, paint: { "circle-color": color("card"), "circle-stroke-color": color("ink"), "circle-stroke-width": ["interpolate", ["linear"], ["zoom"], 14, 0.4, 18, 1.2], "circle-radius": ["interpolate", ["linear"], ["zoom"], 14, 0.8, 18, 3] } },
    { id: "looked-at", type: "circle", source: "looked-at", paint: { "circle-color": color("bad"), "circle-opacity": 0, "circle-stroke-color": color("bad"), "circle-stroke-width": 4, "circle-radius": 18 } },
  ] as LayerSpecification[];
}

/** What of the window's knowledge the survey's picture is made of. */
export const SURVEY_KEYS: (keyof Studio)[] = ["area", "survey", "coarseSurvey", "dragSurvey", "part", "document", "troubles", "space", "world", "at", "lookedAt"];

export function drawSurvey(now: Studio, fill: Fill): void {
  const layout = layoutOf(now), isCoarse = coarseSurveyOf(now) !== null;
  drawArea(now, fill);
  fill("seen", polygons(layout?.seen));
  fill("gaps", polygons(layout?.gaps));
  fill("kept-out", polygons(layout?.kept_out));
  const lines = (layout?.lines ?? []).filter(line => isCoarse || line.flight !== now.part);
  fill("survey-lines", lines.map(line => shapes.line([line.begin, line.end], { coarse: isCoarse, color: isCoarse ? "" : hueOf(line.flight) })));
  fill("survey-ways", isCoarse ? layout!.ways.map(way => shapes.line(way)) : []);
  const shown = (layout?.lines ?? []).filter(line => isCoarse || line.flight === now.part);
  fill("photos", shown.flatMap(line => line.photos.map(place => point(place as LngLat))));
  fill("survey-ribbon", now.space && now.world ? lines.flatMap(line => {
    const course = { points: [line.begin, line.end], up: line.up }, hue = isCoarse ? color("quiet") : hueOf(line.flight);
    return shapes.ribbon(broken(course, isCoarse), shapes.lowest(now.world!), WIDE, HIGH, isCoarse ? "coarse" : "proved").map(one => ({ ...one, properties: { ...one.properties, color: hue } }));
  }) : []);
  fill("footprint", footprint(now, layout));
  fill("looked-at", layout && now.lookedAt ? [point(now.lookedAt)] : []);
}

function drawArea(now: Studio, fill: Fill): void {
  const rings = now.area?.rings ?? [], wrong = now.troubles.filter(one => one.of === "scenario").map(one => one.message).join("\n");
  const outers = rings.filter(ring => ring.what === "outer"), outlines = rings.map(ring => {
    const places = ring.what === "line" ? ring.places : [...ring.places, ring.places[0]!];
    return shapes.line(places, { lit: wrong.split("\n").some(words => words.includes(`${ring.name}:`) || words.includes(`${ring.name},`)) });
  });
  fill("area", [...outers.map(ring => polygon([[...ring.places, ring.places[0]!]])), ...outlines]);
}

/** A coarse line in pieces short enough for a band that is broken. */
function broken(course: { points: unknown[]; up: number[] }, isCoarse: boolean): any {
  if (!isCoarse) return course;
  const [[west, south], [east, north]] = course.points as [LngLat, LngLat], [from, to] = course.up as [number, number];
  const length = Math.hypot((east - west) * shapes.METERS * Math.cos((south * Math.PI) / 180), (north - south) * shapes.METERS);
  const count = Math.max(1, Math.round(length / (4 * WIDE)));
  const share = Array.from({ length: count + 1 }, (_, n) => n / count);
  return { points: share.map(s => [west + s * (east - west), south + s * (north - south)]), up: share.map(s => from + s * (to - from)) };
}

/** What the photo shows that is taken next to where the slider stands; the way leads up in it. */
function footprint(now: Studio, layout: SurveyLayout | null): GeoJSON.Feature[] {
  const taken = proved(now) ? photoAt(now) : null;
  if (!taken || !layout || !now.world || !surveyed(now)) return [];
  const [wide, high] = now.world.degree_m as [number, number], [across, along] = layout.footprint as [number, number];
  const [x, y] = [(taken.line.end[0]! - taken.line.begin[0]!) * wide, (taken.line.end[1]! - taken.line.begin[1]!) * high], length = Math.hypot(x, y) || 1;
  const ahead = [x / length, y / length] as const;
  const corner = (a: number, b: number) => [
    taken.place[0] + (ahead[0] * a - ahead[1] * b) / wide, taken.place[1] + (ahead[1] * a + ahead[0] * b) / high,
  ];
  const [a, b] = [along / 2, across / 2];
  return [polygon([[corner(a, b), corner(a, -b), corner(-a, -b), corner(-a, b), corner(a, b)]])];
}

const polygons = (rings: SurveyLayout["seen"] | undefined): GeoJSON.Feature[] => (rings ?? []).map(polygon);
const polygon = (rings: unknown): GeoJSON.Feature => ({ type: "Feature", properties: {}, geometry: { type: "Polygon", coordinates: rings as LngLat[][] } });
const point = (place: LngLat): GeoJSON.Feature => ({ type: "Feature", properties: {}, geometry: { type: "Point", coordinates: place } });
