// Vector tiles below the scenario, in a plain style of our own: what a layer is goes by its name, as in the schemas of
// OpenMapTiles, Shortbread and Protomaps; of one with another name the lines are drawn. Words are set in the browser's font.
import type { ExpressionSpecification, LayerSpecification } from "maplibre-gl";
import { color } from "./colors";

type Sort = "green" | "water" | "waterway" | "road" | "building" | "boundary" | "place" | "street name" | "none";
const SORTS: [Sort, string[]][] = [
  ["green", ["landcover", "landuse", "park", "land", "natural", "sites"]],
  ["water", ["water", "ocean", "water_polygons"]],
  ["waterway", ["waterway", "water_lines"]],
  ["boundary", ["boundary", "boundaries", "admin"]],
  ["road", ["transportation", "roads", "streets", "road"]],
  ["building", ["building", "buildings"]],
  ["street name", ["transportation_name", "street_labels"]],
  ["place", ["place", "places", "place_labels"]],
  ["none", ["earth", "housenumber", "addresses", "poi", "pois", "aerodrome_label", "mountain_peak", "water_name", "boundary_labels", "street_polygons", "streets_polygons_labels", "water_polygons_labels", "water_lines_labels", "globallandcover"]],
];
const GREEN = ["wood", "forest", "grass", "park", "farmland", "meadow", "scrub", "garden", "cemetery", "nature_reserve", "grassland", "orchard", "vineyard", "allotments", "pitch", "recreation_ground", "village_green"];
const polygons: ExpressionSpecification = ["in", ["geometry-type"], ["literal", ["Polygon", "MultiPolygon"]]];
const lines: ExpressionSpecification = ["in", ["geometry-type"], ["literal", ["LineString", "MultiLineString"]]];
const kind: ExpressionSpecification = ["coalesce", ["get", "class"], ["get", "kind"], ["get", "subclass"], ""];
const name: ExpressionSpecification = ["coalesce", ["get", "name:latin"], ["get", "name"], ""];

/** The layers of the tiles, those that lie lowest first. */
export function vectorLayers(): LayerSpecification[] {
  const names = SORTS.flatMap(([, known]) => known);
  const sortOf = (layer: string): Sort | undefined => SORTS.find(([, known]) => known.includes(layer))?.[0];
  const order = SORTS.map(([sort]) => sort), rank = (layer: string) => order.indexOf(sortOf(layer) ?? "road");
  return names.sort((one, other) => rank(one) - rank(other)).flatMap(layer => drawn(layer, sortOf(layer)));
}

function drawn(layer: string, sort: Sort | undefined): LayerSpecification[] {
  const of = { source: "tiles", "source-layer": layer };
  const words = { "text-field": name, "text-font": ["sans-serif"], "text-size": 12 };
  const inked = { "text-color": color("ink"), "text-halo-color": color("paper"), "text-halo-width": 1.4 };
  switch (sort) {
    case "none": return [];
    case "green": return [{ id: `tiles ${layer}`, type: "fill", ...of, filter: ["all", polygons, ["in", kind, ["literal", GREEN]]], paint: { "fill-color": color("green"), "fill-antialias": false } }];
    case "water": return [{ id: `tiles ${layer}`, type: "fill", ...of, filter: polygons, paint: { "fill-color": color("water") } }];
    case "waterway": return [{ id: `tiles ${layer}`, type: "line", ...of, filter: lines, paint: { "line-color": color("water"), "line-width": 2 } }];
    case "building": return [{ id: `tiles ${layer}`, type: "fill", ...of, filter: polygons, paint: { "fill-color": color("line"), "fill-outline-color": color("quiet") } }];
    case "boundary": return [{ id: `tiles ${layer}`, type: "line", ...of, filter: lines, paint: { "line-color": color("quiet"), "line-width": 1, "line-dasharray": [4, 2] } }];
    case "street name": return [{ id: `tiles ${layer}`, type: "symbol", ...of, filter: lines, layout: { ...words, "symbol-placement": "line" }, paint: inked }];
    case "place": return [{ id: `tiles ${layer}`, type: "symbol", ...of, layout: { ...words, "text-size": 14 }, paint: inked }];
    case "road": return [
      { id: `tiles ${layer}`, type: "line", ...of, filter: lines, layout: { "line-cap": "round" }, paint: { "line-color": color("quiet"), "line-width": ["interpolate", ["exponential", 1.6], ["zoom"], 10, 0.6, 18, 9], "line-opacity": 0.45 } },
      { id: `tiles ${layer} names`, type: "symbol", ...of, filter: ["all", lines, ["has", "name"]], layout: { ...words, "symbol-placement": "line" }, paint: inked },
    ];
    default: return [{ id: `tiles ${layer}`, type: "line", ...of, paint: { "line-color": color("quiet"), "line-width": 1 } }];
  }
}
