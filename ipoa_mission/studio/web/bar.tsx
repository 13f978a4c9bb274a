// The bar on top: what is open, the tools, undo and redo, saving, the view.
import { isMission, isSurvey, proved, send, set, studio, type Studio, type Tool } from "./store";
import { useStudio } from "./use";

const OF_MISSIONS: Tool[] = ["select", "waypoint", "measure"];
const TOOLS: [Tool, string, string, string, string][] = [
  ["select", "↖", "select", "Select and drag", "v"],
  ["waypoint", "◆", "waypoint", "Waypoint after the item that is chosen", "w"],
  ["via", "◆", "via", "Via point", "w"],
  ["polygon", "⬠", "building", "Building, corner by corner", "b"],
  ["cylinder", "○", "mast", "Mast or tree", "m"],
  ["keep-out", "⊘", "keep out", "Keep-out fence", "x"],
  ["keep-in", "▢", "keep in", "Keep-in fence", "f"],
  ["area", "▦", "area", "Area to be surveyed", "a"],
  ["hole", "◌", "hole", "Hole in the area", "h"],
  ["measure", "↔", "measure", "Measure a distance", "d"],
];

/** The tools for what is open: a survey is no flight by way of a place, and has holes where it has an area. */
export function toolsOf(now: Studio) {
  const without: Tool[] = ["waypoint", isSurvey(now) ? "via" : "hole"];
  return TOOLS.filter(([name]) => (isMission(now) ? OF_MISSIONS.includes(name) : !without.includes(name)));
}

export function Bar() {
  const now = useStudio();
  const { document: shown, tool, space, connected } = now;
  if (!shown) return <header class="bar"><h1>studio</h1></header>;
  return (
    <header class="bar">
      <h1>{shown.name}<span class={shown.unsaved ? "unsaved" : "saved"}>{shown.unsaved ? "unsaved" : "saved"}</span></h1>
      <div class="group">
        <button type="button" disabled={!shown.undo} title={shown.undo ? `Undo: ${shown.undo}` : "Undo"} aria-label="Undo"
          onClick={() => send({ kind: "do", what: "undo" })}>↶</button>
        <button type="button" disabled={!shown.redo} title={shown.redo ? `Redo: ${shown.redo}` : "Redo"} aria-label="Redo"
          onClick={() => send({ kind: "do", what: "redo" })}>↷</button>
        <button type="button" class="strong" disabled={!shown.unsaved} onClick={() => send({ kind: "do", what: "save" })}>Save</button>
      </div>
      <div class="tools">
        <div class="group" role="toolbar" aria-label="Tools">
          {toolsOf(now).map(([name, sign, word, words, key]) => (
            <button type="button" key={name} aria-pressed={tool === name} title={`${words} (${key})`} aria-label={words}
              onClick={() => set({ tool: name })}><span aria-hidden="true">{sign}<small>{word}</small></span></button>
          ))}
        </div>
        <div class="group">
          {now.tiles && <button type="button" aria-pressed={now.picture} onClick={() => set({ picture: !now.picture })}>Map</button>}
          <button type="button" disabled={!proved(now)?.homeward.length} aria-pressed={now.homeward} title="Where RTL would lead at the moment that the slider stands at, and from everywhere else; red: not clear"
            onClick={() => set({ homeward: !now.homeward })}>Ways home</button>
          <button type="button" aria-pressed={space} onClick={() => set({ space: !space })}>3-D</button>
          {isMission(now) ? <SaveAs now={now} /> : <button type="button" disabled={!proved(now)} title={`Write ${shown.name}.plan, .waypoints, .json and the report`}
            onClick={() => send({ kind: "do", what: "export" })}>Mission files</button>}
          {!isMission(now) && <button type="button" disabled={!proved(now)} title="The planned flight as a mission file of its own, to be changed item by item: it will be planned and proved no more"
            onClick={() => send({ kind: "do", what: "detach", flight: now.part })}>Edit items</button>}
        </div>
      </div>
      {!connected && <p class="lost" role="status">The studio does not answer. What was done is kept; it will be back when the program is.</p>}
    </header>
  );
}

/** The mission in the other format, or as a file of its own. */
function SaveAs({ now }: { now: Studio }) {
  return <>{([".plan", ".waypoints"] as const).map(suffix => (
    <button type="button" key={suffix} disabled={!now.mission} title={`Write ${now.document?.name}${suffix} beside it, over nothing`}
      onClick={() => send({ kind: "save_as", suffix })}>As {suffix}</button>
  ))}</>;
}

/** Keys that work wherever no field is written in. */
export function listenToKeys(): void {
  addEventListener("keydown", event => {
    const held = event.ctrlKey || event.metaKey, saves = held && event.key === "s";
    if (!saves && event.target instanceof HTMLElement && event.target.matches("input, textarea, select")) return;
    const what = saves ? "save"
      : held && (event.key === "y" || (event.shiftKey && event.key.toLowerCase() === "z")) ? "redo"
        : held && event.key === "z" ? "undo" : null;
    if (what) {
      event.preventDefault();
      send({ kind: "do", what });
    } else if (!held && !event.altKey) {
      const tool = toolsOf(studio).find(one => one[4] === event.key);
      if (tool) set({ tool: tool[0] });
      if (event.key === "Escape") set({ tool: "select", selected: null });
      if (event.key === "3") set({ space: true });
      if (event.key === "2") set({ space: false });
      if (event.key === "?") showKeys(document.querySelector(".keys"));
    }
  });
}

function showKeys(keys: HTMLDetailsElement | null): void {
  if (keys) keys.open = true;
  keys?.scrollIntoView();
}
