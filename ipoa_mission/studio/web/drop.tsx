// Files that are dropped on the page: the server keeps them beside the scenario, the user says what they are.
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { edit, isSurvey, planRest, send, set, studio, type Dropped, type Studio } from "./store";

const KINDS: [string, string][] = [["buildings", "Buildings to fly round"], ["no_fly", "Zones to keep out of"], ["flight_area", "The area to stay in"], ["survey", "The area to be surveyed"]];

/** Keep a file beside the scenario; what it can be taken for. */
export async function keep(file: File): Promise<Dropped | null> {
  const answer = await fetch(new URL(`drop/${encodeURIComponent(file.name)}`, document.baseURI), { method: "POST", body: file });
  const told = await answer.json() as Dropped & { message?: string };
  if (answer.ok) return told;
  set({ notice: told.message ?? "the file was not taken" });
  return null;
}

function use(dropped: Dropped, kind: string): void {
  if (dropped.kind === "elevation") {
    edit(`ground from ${dropped.file}`, { op: "put", path: ["terrain"], value: { kind: "elevation", file: dropped.file } });
  } else if (dropped.kind === "mission") {
    edit(`places from ${dropped.file}`, ...dropped.changes);
  } else if (kind === "survey") {
    edit(`area from ${dropped.file}`, { op: "map_area", file: dropped.file });
  } else {
    edit(`${kind} from ${dropped.file}`, { op: "add", to: "maps", table: { kind, file: dropped.file }, place: null, ring: null, at: null });
  }
}

/** What a dropped file is, asked where one looks: on top of all that is said of the flight. */
export function Question({ now }: { now: Studio }) {
  const asked = now.dropped, first = useRef<HTMLButtonElement>(null);
  useLayoutEffect(() => first.current?.focus(), [asked]); // at once: later it took the focus from who was quick
  if (!asked) return null;
  const close = () => set({ dropped: null });
  return (
    <section class="question" role="group" aria-label={`What is ${asked.file}?`}>
      <p>{asked.kind === "mission" || asked.kind === "log" ? "What is to be done with" : "What is"} <b>{asked.file}</b>?</p>
      <p class="column">{asked.kind === "mission" && <>
        <button type="button" ref={first} onClick={() => { use(asked, ""); close(); }}>Take its places, home and fence into this scenario</button>
        <button type="button" onClick={() => { send({ kind: "open", path: asked.file }); close(); }}>Open it by itself, in this scenario's world</button></>}
        {asked.kind === "log" && <button type="button" ref={first} onClick={() => { planRest(now, asked.file); close(); }}>Plan what it has left of the survey</button>}
        {asked.kind === "map" && KINDS.map(([kind, words], n) => <button type="button" key={kind} ref={n ? null : first} onClick={() => { use(asked, kind); close(); }}>{words}</button>)}
        <button type="button" onClick={close}>Nothing: leave it</button></p>
    </section>
  );
}

export function Drop() {
  const take = async (files: FileList | null) => {
    for (const file of files ?? []) {
      const dropped = await keep(file);
      if (dropped?.kind === "log" && !isSurvey(studio)) set({ notice: `${dropped.file} is kept; a log is opened on the start page, or says what of a survey was flown` });
      else if (dropped && dropped.kind !== "elevation") set({ dropped });
      else if (dropped) use(dropped, "");
    }
  };
  useEffect(() => {
    const over = (event: DragEvent) => event.preventDefault();
    const drop = (event: DragEvent) => { event.preventDefault(); void take(event.dataTransfer?.files ?? null); };
    addEventListener("dragover", over);
    addEventListener("drop", drop);
    return () => { removeEventListener("dragover", over); removeEventListener("drop", drop); };
  }, []);
  return (
    <details class="panel">
      <summary>Maps and missions from files</summary>
      <p class="note">Drop them anywhere on the page: GeoJSON, .osm and .osm.pbf, KML, Shapefile and others for buildings and zones; GeoTIFF or .hgt for the ground; .plan or .waypoints for home, places and fence; a log of a survey that was broken off. They are kept beside the scenario.</p>
      <label class="field wide"><span>Or choose one</span><input type="file" multiple onChange={event => { void take(event.currentTarget.files); event.currentTarget.value = ""; }} /></label>
    </details>
  );
}
