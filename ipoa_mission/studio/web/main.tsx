// The page: a map, what is known about the flight beside it, its profile below.
import "./trusted";
import "maplibre-gl/dist/maplibre-gl.css";
import "../../report/assets/palette.css";
import "./studio.css";
import { render } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Bar, listenToKeys } from "./bar";
import { makeMap } from "./map";
import { showSpots } from "./spots";
import { useStudio } from "./use";
import { Verdict } from "./verdict";

function MapView() {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const map = makeMap(place.current!);
    showSpots(map);
    (window as unknown as { map: unknown }).map = map; // for tests, and for the curious
  }, []);
  return <div class="map" ref={place} role="region" aria-label="Map" />;
}

function Page() {
  const now = useStudio();
  return (
    <>
      <Bar />
      <main>
        <MapView />
        <aside class="side"><Verdict now={now} /></aside>
      </main>
    </>
  );
}

listenToKeys();
render(<Page />, document.getElementById("app")!);
