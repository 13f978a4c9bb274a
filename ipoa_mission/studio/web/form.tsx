// What can be changed by numbers: the thing that is chosen, and the flight's limits. A field says what it expects.
import { useState } from "preact/hooks";
import type { Scenario } from "./messages";
import { nameOf, remove } from "./chosen";
import { edit, isSurvey, proved, studio, type Path, type Studio } from "./store";

interface Field {
  path: Path;
  label: string;
  unit?: string;
  step?: number;
  choices?: string[];
  unset?: string;
}

const LIMITS: Field[] = [
  { path: ["safety_distance"], label: "Safety distance", unit: "m", step: 0.5, unset: "1" },
  { path: ["vehicle", "cruise_speed"], label: "Cruise speed", unit: "m/s", step: 0.5 },
  { path: ["planning", "max_height_above_ground"], label: "Ceiling above ground", unit: "m", step: 5, unset: "none" },
  { path: ["planning", "min_height_above_ground"], label: "Floor above ground", unit: "m", step: 1, unset: "safety" },
  { path: ["planning", "max_climb_angle_deg"], label: "Steepest climb", unit: "°", step: 5, unset: "any" },
  { path: ["planning", "max_descent_angle_deg"], label: "Steepest descent", unit: "°", step: 5, unset: "any" },
  { path: ["wind", "speed"], label: "Wind", unit: "m/s", step: 1, unset: "0" },
  { path: ["wind", "from_deg"], label: "Wind from", unit: "°", step: 15, unset: "0" },
];
const WAYS: Field[] = [
  { path: ["vehicle", "autopilot"], label: "Autopilot", choices: ["px4", "ardupilot"] },
  { path: ["route", "mode"], label: "Waypoints", choices: ["fastest", "corridor", "even", "spline"] },
  { path: ["route", "ending"], label: "Ends by", choices: ["rtl", "land"] },
];
const NAMES: Record<string, string> = { rtl: "return home (rtl)", land: "landing there" };
const SIZES: Record<string, [string, string][]> = {
  place: [["up", "m above home"], ["height_above_ground", "m above ground"], ["altitude_amsl", "m AMSL"]],
  solid: [["height", "m"], ["radius", "m"], ["width", "m"], ["depth", "m"], ["heading_deg", "°"], ["base", "m above home"]],
};

export function valueAt(table: unknown, path: Path): unknown {
  return path.reduce<unknown>((here, step) => (here as Record<string | number, unknown> | undefined)?.[step], table);
}

export function Chosen({ now }: { now: Studio }) {
  const path = now.selected;
  const table = path && now.document ? valueAt(now.document.scenario, path) as Record<string, unknown> | undefined : undefined;
  if (!path || !table) return null;
  const kind = String(path[0]);
  if (kind === "survey") return null; // it has a form of its own
  const sizes = kind === "obstacles" ? SIZES.solid! : kind === "home" ? [["altitude_amsl", "m AMSL"] as [string, string]] : SIZES.place!;
  return (
    <section aria-label="Chosen">
      <h2>{nameOf(path)}</h2>
      {kind === "obstacles" && (
        <label class="field"><span>Name</span>
          <Typed type="text" value={String(table.name ?? "")} maxLength={60}
            change={value => edit("name changed", { op: "put", path: [...path, "name"], value })} /></label>
      )}
      {sizes.filter(([key]) => key in table).map(([key, unit]) => (
        <NumberField key={key} field={{ path: [...path, key], label: (key[0]!.toUpperCase() + key.slice(1)).replaceAll("_", " ").replace(" deg", ""), unit, step: key === "heading_deg" ? 5 : 1 }} now={now} />
      ))}
      {kind === "obstacles" && isFlownOver(now, nameOf(path)) && <p class="note">The flight passes over it. If it is higher, say so: then it is flown round.</p>}
      {["via", "start", "goal", "rally"].includes(kind) && <Datum path={path} table={table} />}
      {PLACES.includes(kind) && <Coordinates path={path} table={table} />}
      {kind === "fence" && <p class="note">{table.inclusion === false ? "The vehicle keeps out of it." : "The vehicle stays inside of it."} It goes into the mission.</p>}
      {typeof path.at(-1) === "number" && <button type="button" onClick={() => remove(path)}>Remove</button>}
    </section>
  );
}

/** Whether the proved path to the goal leads over a thing; ways home do so as high as they can. */
function isFlownOver(now: Studio, name: string): boolean {
  const plan = proved(now), turns = plan?.course.returns_at ?? null;
  return plan?.nearby.some(body => body.look === "below" && body.name === name && (turns === null || body.begins < plan.course.along[turns]!)) ?? false;
}

const PLACES = ["home", "start", "goal", "via", "rally"];

/** Where a place is, as its file has it: latitude and longitude in one line, or meters from home. */
function Coordinates({ path, table }: { path: Path; table: Record<string, unknown> }) {
  const keys = "latitude_deg" in table ? ["latitude_deg", "longitude_deg"] : ["east", "north"];
  const change = (text: string) => {
    const numbers = text.split(/[,;\s]+/).filter(Boolean).map(Number);
    if (numbers.length !== 2 || !numbers.every(Number.isFinite)) return;
    edit(`${nameOf(path)} moved`, ...keys.map((key, n) => ({ op: "put" as const, path: [...path, key], value: numbers[n]! })));
  };
  return (
    <label class="field"><span>{keys[0] === "east" ? "East, north of home [m]" : "Latitude, longitude [°]"}</span>
      <Typed type="text" value={keys.map(key => String(table[key] ?? 0)).join(", ")} change={change} /></label>
  );
}

const DATA: [string, string][] = [["up", "home"], ["height_above_ground", "the ground"], ["altitude_amsl", "the sea (AMSL)"]];

/** What a place's height counts from; it stays as high when that is changed. */
function Datum({ path, table }: { path: Path; table: Record<string, unknown> }) {
  const spot = studio.world?.spots.find(one => one.path.join() === path.join()), now = DATA.find(([key]) => key in table)?.[0];
  if (!spot || !now) return null;
  const change = (key: string) => {
    const height = key === "up" ? spot.up : key === "altitude_amsl" ? spot.up + studio.world!.home_amsl : spot.above_ground;
    edit("height counts from elsewhere", { op: "take", path: [...path, now] }, { op: "put", path: [...path, key], value: Math.round(height * 10) / 10 });
  };
  return (
    <label class="field"><span>Height counts from</span>
      <select value={now} onChange={event => change(event.currentTarget.value)}>{DATA.map(([key, words]) => <option key={key} value={key}>{words}</option>)}</select></label>
  );
}

export function Limits({ now }: { now: Studio }) {
  if (!now.document) return null;
  return (
    <details class="panel" open>
      <summary>Limits and ways</summary>
      {LIMITS.map(field => <NumberField key={field.label} field={field} now={now} />)}
      {WAYS.map(field => <ChoiceField key={field.label} field={field} now={now} />)}
      {!isSurvey(now) && <HeightForAll now={now} />}
    </details>
  );
}

interface Numeric {
  label: string;
  unit?: string;
  about?: string;
  value: number | null;
  step: number | "any";
  bare?: boolean;
  unset?: string;
  change: (value: number | null) => void;
}

/** A number with its unit; emptied it is none. */
export function NumberInput({ label, unit, about, value, step, bare, unset, change }: Numeric) {
  const settle = (text: string) => {
    const number = text.trim() === "" ? null : Number(text);
    if (number !== value && (number === null || Number.isFinite(number))) change(number);
  };
  const input = <Typed type="number" step={step} value={value === null ? "" : String(value)} placeholder={unset ?? ""} label={bare ? label : undefined} change={settle} />;
  return bare ? input : <label class="field" title={about || undefined}><span>{label}</span>{input}<em>{unit ?? ""}</em></label>;
}

interface Typing {
  type: "text" | "number";
  value: string;
  change: (text: string) => void;
  step?: number | "any";
  placeholder?: string;
  maxLength?: number;
  label?: string | undefined;
}

/** An input that keeps what is being typed when an answer arrives meanwhile. */
function Typed({ type, value, change, label, ...rest }: Typing) {
  const [draft, setDraft] = useState<string | null>(null);
  const settle = (event: { currentTarget: HTMLInputElement }) => { setDraft(null); change(event.currentTarget.value); };
  const keep = (event: { currentTarget: HTMLInputElement }) => setDraft(event.currentTarget.value);
  const all = { ...rest, "aria-label": label, value: draft ?? value, onInput: keep, onChange: settle, onBlur: () => setDraft(null) };
  return type === "number" ? <input type="number" {...all} /> : <input type="text" {...all} />;
}

function NumberField({ field, now }: { field: Field; now: Studio }) {
  const value = valueAt(now.document?.scenario, field.path);
  const change = (text: string) => {
    const label = `${field.label.toLowerCase()} changed`;
    if (text === "") edit(label, { op: "take", path: field.path });
    else if (Number.isFinite(Number(text))) edit(label, { op: "put", path: field.path, value: Number(text) });
  };
  return (
    <label class="field"><span>{field.label}</span>
      <Typed type="number" step={field.step ?? "any"} value={value === undefined ? "" : String(value)} placeholder={field.unset ?? ""} change={change} />
      <em>{field.unit ?? ""}</em></label>
  );
}

function ChoiceField({ field, now }: { field: Field; now: Studio }) {
  const value = String(valueAt(now.document?.scenario, field.path) ?? field.choices![0]);
  return (
    <label class="field"><span>{field.label}</span>
      <select value={value} onChange={event => edit(`${field.label.toLowerCase()} changed`, { op: "put", path: field.path, value: event.currentTarget.value })}>
        {field.choices!.map(choice => <option key={choice} value={choice}>{NAMES[choice] ?? choice}</option>)}
      </select></label>
  );
}

/** Every place of the flight as high above ground: one change, one undo. */
function HeightForAll({ now }: { now: Studio }) {
  const scenario = now.document!.scenario as Scenario;
  const change = (height: number) => {
    const places: [Path, object][] = [[["start"], scenario.start ?? {}], [["goal"], scenario.goal ?? {}], ...(scenario.via ?? []).map((via, n): [Path, object] => [["via", n], via])];
    const changes = places.flatMap(([path, place]) => [
      ...["up", "altitude_amsl"].filter(key => key in place).map(key => ({ op: "take" as const, path: [...path, key] })),
      { op: "put" as const, path: [...path, "height_above_ground"], value: height },
    ]);
    edit(`${height} m above ground for all`, ...changes);
  };
  return (
    <label class="field"><span>Height of all places</span>
      <input type="number" step="1" min="1" placeholder="its own"
        onChange={event => { if (Number(event.currentTarget.value) > 0) change(Number(event.currentTarget.value)); event.currentTarget.value = ""; }} />
      <em>m above ground</em></label>
  );
}
