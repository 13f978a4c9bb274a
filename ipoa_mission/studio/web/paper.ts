// The map on paper: all of the flight, as wide as the paper; then it is again as it was.
import type { CameraOptions, Map as MapLibre } from "maplibre-gl";
import { fit } from "./map";
import { studio } from "./store";

const LONGEST = 4000; // that a key waits for all tiles [ms]

export function fitOnPaper(map: MapLibre): void {
  const { style } = map.getContainer();
  let before: CameraOptions | null = null;
  const prepare = () => {
    if (!studio.world) return;
    before ??= { center: map.getCenter(), zoom: map.getZoom(), bearing: map.getBearing(), pitch: map.getPitch() };
    Object.assign(style, { width: "180mm", height: "110mm" });
    map.resize();
    fit(map, studio.world, false);
    map.redraw();
  };
  addEventListener("beforeprint", prepare); // by the browser's own menu, which waits for nothing
  addEventListener("keydown", event => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "p" || event.shiftKey || !studio.world) return;
    event.preventDefault();
    prepare();
    const drawn = new Promise<unknown>(done => { map.once("idle", done); setTimeout(done, LONGEST); });
    void drawn.then(() => requestAnimationFrame(() => print()));
  });
  addEventListener("afterprint", () => {
    Object.assign(style, { width: "", height: "" });
    map.resize();
    if (before) map.jumpTo(before);
    before = null;
  });
}
