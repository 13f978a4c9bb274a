// The page before a file is open: files of the folder, a new scenario from a place.
import { useEffect, useState } from "preact/hooks";
import { send, set, type Studio } from "./store";

const SORTS: [RegExp, string][] = [[/\.toml$/i, "scenario"], [/\.(plan|waypoints)$/i, "mission"], [/./, "log of a flight"]];

export function StartPage({ now }: { now: Studio }) {
  const start = now.start!, [place, setPlace] = useState(""), [altitude, setAltitude] = useState("");
  const trouble = now.troubles.find(one => one.of === "file");
  useEffect(() => {
    const over = (event: DragEvent) => event.preventDefault();
    const drop = (event: DragEvent) => { event.preventDefault(); void take(event.dataTransfer?.files[0]); };
    addEventListener("dragover", over);
    addEventListener("drop", drop);
    return () => { removeEventListener("dragover", over); removeEventListener("drop", drop); };
  }, []);
  const begin = (event: Event) => {
    event.preventDefault();
    set({ troubles: [] });
    send({ kind: "begin", place, altitude: Number(altitude) || 0 });
  };
  return (
    <main class="opening">
      {trouble && <section class="bad" role="alert"><p><b aria-hidden="true">✕</b> {trouble.message}</p>{trouble.hint && <p class="note">Try: {trouble.hint}</p>}</section>}
      {now.notice && <p class="note" role="status">{now.notice}</p>}
      <section><h2>Open a file</h2>
        <label class="field wide"><span>A scenario (.toml), a mission (.plan, .waypoints) or a log (.tlog, .bin, .ulg); or drop it anywhere</span>
          <input type="file" accept=".toml,.plan,.waypoints,.tlog,.bin,.ulg" onChange={event => void take(event.currentTarget.files?.[0])} /></label>
        <p class="note">It is kept in {start.folder}; nothing there is written over.</p>
        <p class="note">For a picture of the ground start with --tiles, such as https://tile.openstreetmap.org/{"{z}/{x}/{y}"}.png.</p></section>
      <section><h2>A new scenario</h2>
        <form onSubmit={begin}>
          <label class="field wide"><span>Home: degrees</span><input type="text" value={place} required placeholder="47.397742, 8.545594" onInput={event => setPlace(event.currentTarget.value)} /></label>
          <label class="field"><span>Its height</span><input type="number" value={altitude} required min="-450" max="9000" step="any" onInput={event => setAltitude(event.currentTarget.value)} /><em>m AMSL</em></label>
          <p class="buttons"><button type="submit" class="strong">Begin</button></p>
        </form></section>
      <Files words="Examples (opened as a copy)" packed files={start.examples} />
      <Files words="In this folder" files={start.here} />
    </main>
  );
}

function Files({ words, files, packed }: { words: string; files: string[]; packed?: boolean }) {
  if (!files.length) return null;
  return (
    <section><h2>{words}</h2>
      <ul class="files">{files.map(path => {
        const end = Math.max(path.lastIndexOf("/"), path.lastIndexOf("\\")), sort = SORTS.find(([suffix]) => suffix.test(path))![1];
        return (
          <li key={path}><button type="button" onClick={() => { set({ troubles: [] }); send({ kind: "open", path }); }}>
            <b>{path.slice(end + 1)}</b> <small>{sort}{packed ? "" : `, ${path.slice(0, end)}`}</small></button></li>
        );
      })}</ul></section>
  );
}

async function take(file: File | undefined): Promise<void> {
  if (!file) return;
  set({ notice: `reading ${file.name} …`, troubles: [] });
  const answer = await fetch(new URL(`drop/${encodeURIComponent(file.name)}`, document.baseURI), { method: "POST", body: file });
  const told = await answer.json() as { address?: string; message?: string };
  if (told.address) location.assign(new URL(told.address, document.baseURI));
  else set({ notice: told.message ?? "the file was not taken" });
}
