// A survey: what is asked of it, what is seen, by which flights, and which of them is looked at.
import { NumberInput, valueAt } from "./form";
import { bringInSight } from "./map";
import { SURVEY_HELP } from "./words";
import type { PlannedSurvey, Scenario, SurveyLayout } from "./messages";
import { keep } from "./drop";
import { choosePart, coarseSurveyOf, edit, isSurvey, layoutOf, planRest, set, surveyed, SURVEY, type Change, type LngLat, type Path, type Studio } from "./store";
import { hueOf } from "./survey-map";
import { meters, seconds, share } from "./words";

type Section = NonNullable<Scenario["survey"]>;
const ENOUGH = 0.999; // share of what can be seen
const OVERLAP = 70; // where a camera comes with none [%]
const put = (key: string, value: unknown): Change => ({ op: "put", path: ["survey", key], value });
const take = (key: string): Change => ({ op: "take", path: ["survey", key] });

/** What is known of a survey as a whole, before anything of one flight. */
export function SurveyVerdict({ now }: { now: Studio }) {
  const coarse = coarseSurveyOf(now), survey = surveyed(now);
  if (survey && !coarse) {
    const warned = survey.flights.filter(one => one.plan.warnings.length), first = warned[0]?.plan.warnings[0];
    const count = survey.flights.length, layout = survey.layout, keeps = leastKept(survey);
    const isUnsure = warned.length > 0 || layout.short.length > 0 || layout.share < ENOUGH;
    return (
      <p class={isUnsure ? "amber" : "good"}><b aria-hidden="true">{isUnsure ? "!" : "✓"}</b> Proved.
        {" "}{seen(layout)} of the visible part is covered, {count === 1 ? "in one flight" : `in ${count} flights`}.{keeps && ` ${keeps}`}{layout.short.length > 0 && ` Photos overlap less than was asked: ${layout.short.join("; ")}.`}
        {first && <> But read before you fly: {warned.length > 1 || count > 1 ? `${warned[0]!.plan.name}: ` : ""}{first}{more(survey)}.</>}</p>
    );
  }
  if (!coarse) return <p class="coarse">Looking at the area …</p>;
  return (
    <p class="coarse"><b aria-hidden="true">≈</b> {now.dragSurvey ? "While you drag: " : ""}{coarse.layout.lines.length} lines, laid at once. They see {seen(coarse.layout)} of what
      can be seen. No flight is planned yet: nothing is proved, neither clearance nor battery.</p>
  );
}

const seen = (layout: SurveyLayout): string => `${(Math.floor(layout.share * 1e4) / 100).toFixed(2)} %`;

function more(survey: PlannedSurvey): string {
  const count = survey.flights.reduce((sum, one) => sum + one.plan.warnings.length, 0) - 1;
  return count > 0 ? `, and ${count} more` : "";
}

/** The flight that keeps the least beyond what is required. */
function leastKept(survey: PlannedSurvey): string {
  const plans = survey.flights.map(one => one.plan).filter(plan => plan.kept !== null);
  if (!plans.length) return "";
  const least = plans.reduce((one, other) => (other.kept! - other.required < one.kept! - one.required ? other : one));
  const who = least.confidence === null ? "Predicted" : `${share(least.confidence)} of flights keep`;
  return `${who} ${meters(least.kept!, 2)} from ${least.nearest}; ${meters(least.required, 2)} required.`;
}

/** What a survey comes to, in large. */
export function SurveyFigures({ now }: { now: Studio }) {
  const coarse = coarseSurveyOf(now), survey = coarse ? null : surveyed(now), layout = layoutOf(now);
  if (!layout) return null;
  const flights = survey?.flights.length ?? 0;
  return (
    <dl class={`figures${survey ? "" : " rough"}`}>
      {survey ? <div><dt>{flights === 1 ? "flight" : `${flights} flights`}</dt><dd>{seconds(survey.total_s)}<small>{flights === 1 ? "from take-off to landing" : "in the air, all together"}</small></dd></div>
        : <div><dt>lines, about</dt><dd>{seconds(coarse!.seconds)}<small>without take-off and the ways there and home</small></dd></div>}
      <div><dt>seen</dt><dd>{seen(layout)}<small>{area(layout.area_m2)}{layout.gaps_m2 > 0.5 ? `, ${layout.gaps_m2.toFixed(0)} m² in gaps` : ", no gap"}</small></dd></div>
      <div><dt>lines</dt><dd>{layout.lines.length}<small>{meters(layout.spacing)} apart, {layout.height[0] === layout.height[1] ? meters(layout.height[0]!) : `${layout.height[0]!.toFixed(1)} to ${meters(layout.height[1]!)}`} above ground</small></dd></div>
      {layout.trigger !== null && <div><dt>photos</dt><dd>{layout.photos}<small>one each {meters(layout.trigger)} or less</small></dd></div>}
      {(layout.front || layout.side) && <div><dt>overlap, at least</dt><dd>{[layout.front, layout.side].map(one => (one ? percent(one.share) : "–")).join(", ")}<small>ahead and to the side</small></dd></div>}
      {survey?.energy_wh != null && <div><dt>energy</dt><dd>{survey.energy_wh.toFixed(1)} Wh<small>{flights === 1 ? "" : `${flights} batteries`}</small></dd></div>}
    </dl>
  );
}

const NOISE = 0.2; // of what places as they are written make of an overlap [%]
const percent = (value: number): string => `${Math.floor(100 * value + NOISE)} %`;
const area = (square: number): string => (square < 10_000 ? `${square.toFixed(0)} m²` : `${(square / 10_000).toFixed(2)} ha`);

const MOST_GAPS = 5;
const SMALL = 0.01; // of a line's spacing: a narrower gap, as long as the spacing, is not worth a line

/** Where a survey sees least: each line leads to its place. */
export function SeesLeast({ now }: { now: Studio }) {
  const layout = layoutOf(now);
  if (!layout) return null;
  const look = (place: LngLat) => { bringInSight(place); set({ lookedAt: place }); };
  const gaps = layout.gaps.map(rings => ({ place: rings[0]![0] as LngLat, size: rings.reduce((rest, ring, n) => rest + (n ? -1 : 1) * sizeOf(ring as LngLat[], now), 0) })).filter(gap => gap.size > (layout.spacing * SMALL) * layout.spacing).sort((one, other) => other.size - one.size);
  const rows: [string, LngLat][] = [
    ...gaps.slice(0, MOST_GAPS).map(({ place, size }): [string, LngLat] => [`a gap of ${size.toFixed(1)} m²`, place]),
    ...(layout.front ? [[`overlap ahead ${percentOf(layout.front.share)}, the smallest`, layout.front.place as LngLat] as [string, LngLat]] : []),
    ...(layout.side ? [[`overlap to the side ${percentOf(layout.side.share)}, the smallest`, layout.side.place as LngLat] as [string, LngLat]] : []),
  ];
  if (!rows.length) return null;
  return (
    <section aria-label="Where it sees least">
      <h2>Where it sees least</h2>
      <ul class="bindings">{rows.map(([words, place], n) => <li key={n}><button type="button" class={words.startsWith("a gap") ? "danger" : "slow"} onClick={() => look(place)}>{words}</button></li>)}</ul>
      {gaps.length > MOST_GAPS && <p class="note">and {gaps.length - MOST_GAPS} smaller gaps</p>}
      <p class="note">Shaded is what is seen, gray where obstacles leave no room for lines, red what is not seen.</p>
    </section>
  );
}

const percentOf = (value: number): string => `${(100 * value).toFixed(1)} %`;
function sizeOf(ring: LngLat[], now: Studio): number {
  const [wide, high] = now.world?.degree_m ?? [1, 1], [x0, y0] = ring[0]!;
  const flat = ring.map(([lng, lat]) => [(lng - x0) * wide!, (lat - y0) * high!] as const);
  return Math.abs(flat.reduce((sum, [x, y], n) => sum + x * flat[(n + 1) % flat.length]![1] - flat[(n + 1) % flat.length]![0] * y, 0)) / 2;
}

/** The flights, each with its file; the chosen one is shown in map, profile and space. */
export function SurveyFlights({ now }: { now: Studio }) {
  const survey = now.survey, isStale = !surveyed(now) || now.dragSurvey !== null;
  if (!survey || !isSurvey(now)) return null;
  const hasEnergy = survey.energy_wh !== null, hasPhotos = survey.layout.trigger !== null;
  return (
    <section aria-label="Flights" class={`flights${isStale ? " stale" : ""}`} aria-busy={isStale}>
      <h2>{isStale ? "Flights of before: not of what is drawn now" : survey.flights.length === 1 ? "One flight" : `${survey.flights.length} flights, one after the other`}</h2>
      <div class="scroll" tabIndex={0} role="region" aria-label="Flights side by side">
        <table>
          <thead><tr><th scope="col">file</th><th scope="col">takes</th>{hasEnergy && <th scope="col">energy</th>}<th scope="col">keeps</th></tr></thead>
          <tbody>
            {survey.flights.map(({ file, lines, photos, plan }, n) => (
              <tr key={file} class={n === now.part ? "chosen" : ""}>
                <th scope="row"><button type="button" aria-pressed={!isStale && n === now.part} disabled={isStale} onClick={() => choosePart(n)}>
                  <i class="swatch" style={{ background: n === now.part ? "var(--planned)" : hueOf(n) }} />{file}</button>
                  <small>{lines} lines{hasPhotos && `, ${photos} photos`}{now.flownParts.includes(plan.name) && ", ✓ flown"}{plan.warnings.length > 0 && <b class="amber">, ! {plan.warnings.length} to read</b>}</small></th>
                <td>{seconds(plan.total_s)}</td>
                {hasEnergy && <td>{plan.energy_wh === null ? "–" : `${plan.energy_wh.toFixed(1)} Wh`}{plan.battery_left !== null && <small>{share(plan.battery_left)} left</small>}</td>}
                <td>{plan.kept === null ? "–" : <>{meters(plan.kept, 2)}<small>{plan.nearest}</small></>}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {survey.flights.length > 1 && <p class="note">The chosen one is in map, profile and space. Each ends where it began; there the battery is changed.</p>}
      {survey.flown.length > 0 && <p class="note">Left by {survey.flown.join(", ")}: what was flown by then is not planned again. <button type="button" onClick={() => planRest(now, null)}>Plan all of it again</button></p>}
      <Broken now={now} />
    </section>
  );
}

/** A survey that was broken off is gone on with, by the log of what was flown. */
function Broken({ now }: { now: Studio }) {
  const take = async (files: FileList | null) => {
    for (const file of files ?? []) {
      const kept = await keep(file);
      if (kept?.kind === "log") planRest(now, kept.file);
      else if (kept) set({ notice: `${kept.file} is no log of a flight` });
    }
  };
  return <label class="field wide"><span>Was it broken off? Its log says where</span><input type="file" accept=".tlog,.bin,.ulg" onChange={event => { void take(event.currentTarget.files); event.currentTarget.value = ""; }} /></label>;
}

/** Which flight is to be uploaded, and on a link that the battery is charged, which counts after one was flown. */
export function NextFlight({ now, onLink, charged, say }: { now: Studio; onLink: boolean; charged: boolean; say: (charged: boolean) => void }) {
  const survey = surveyed(now), count = survey?.flights.length ?? 0, chosen = survey?.flights[now.part]?.plan.name ?? "";
  if (!survey) return null;
  const next = survey.flights.findIndex(one => !now.flownParts.includes(one.plan.name));
  return (
    <div role="group" aria-label="Which flight">
      {count > 1 && <p class="note">{chosen} is flight {now.part + 1} of {count}{now.flownParts.includes(chosen) ? ", and was flown" : ""}.
        {next >= 0 && next !== now.part && <> <button type="button" onClick={() => choosePart(next)}>Take {survey.flights[next]!.plan.name}</button></>}</p>}
      {onLink && <label><input type="checkbox" checked={charged} onChange={event => say(event.currentTarget.checked)} /> {now.flownParts.length > 0 && `${now.flownParts.at(-1)} has landed: `}a charged battery is in, and nobody is near the propellers</label>}
    </div>
  );
}

/** Whether the user has to say that the battery is changed. */
export const asksBattery = (now: Studio): boolean => surveyed(now) !== null && now.flownParts.length > 0;

/** What is asked of a survey, in words with units. */
export function SurveyForm({ now }: { now: Studio }) {
  if (!now.document) return null;
  if (!isSurvey(now)) {
    return (
      <details class="panel survey">
        <summary>Survey</summary>
        <p class="note">See all of an area, in place of a flight to the goal: in parallel lines, in as few flights as the battery allows.</p>
        <p class="buttons left"><button type="button" onClick={() => set({ tool: "area" })}>Draw an area …</button>
          <button type="button" onClick={() => set({ tool: "corridor" })}>Draw a corridor …</button></p>
      </details>
    );
  }
  const survey = now.document.scenario.survey as Section, layout = layoutOf(now);
  const isOwn = now.area?.rings.some(ring => ring.path !== null) ?? false, isChosen = now.selected?.join() === SURVEY.join();
  const number = (key: string, label: string, unit: string, step: number, unset: string, about = SURVEY_HELP[key]) => (
    <NumberInput label={label} unit={unit} step={step} about={about ?? ""} unset={unset} value={(survey as Record<string, unknown>)[key] as number ?? null}
      change={value => edit(`${label.toLowerCase()} changed`, value === null ? take(key) : put(key, value))} />
  );
  return (
    <details class="panel survey" open>
      <summary>Survey</summary>
      <p class="buttons left">
        {isOwn && <button type="button" aria-pressed={isChosen} onClick={() => set({ selected: isChosen ? null : SURVEY })}>Corners</button>}
        {!isOwn && (now.area?.rings.length ?? 0) > 0 && <button type="button" onClick={() => ownArea(now)}>Edit it here</button>}
        <button type="button" onClick={() => set({ tool: "area" })}>{isOwn && !survey.line ? "Another area …" : "Draw an area …"}</button>
        {isOwn && !survey.line && <button type="button" onClick={() => set({ tool: "hole" })}>A hole …</button>}
        <button type="button" onClick={() => removeSurvey(now)}>Remove the survey</button></p>
      {isChosen && isOwn && <p class="note">Drag a corner, or a plus for a corner more; Delete takes the focused one out. ✥ moves all.</p>}
      {survey.area && <p class="note">Its area is that of <b>{String(survey.area).split(/[\\/]/).at(-1)}</b>.</p>}
      {isChosen && <Rings now={now} />}
      {survey.width != null && number("width", "Width of the corridor", "m", 5, "")}
      <Sees now={now} survey={survey} />
      {survey.camera ? <HeightOrDetail survey={survey} layout={layout} /> : number("height_above_ground", "Height above ground", "m", 5, "")}
      {survey.camera ? (
        <>
          <Percent label="Front overlap" of="front_overlap" survey={survey} />
          {survey.line_spacing == null && <Percent label="Side overlap" of="side_overlap" survey={survey} />}
          {survey.line_spacing != null && number("line_spacing", "Line spacing", "m", 1, "")}
        </>
      ) : number("line_spacing", "Line spacing", "m", 1, "")}
      {survey.camera && <label class="check"><input type="checkbox" checked={survey.gimbal === "nadir"} onChange={event => edit("gimbal", event.currentTarget.checked ? put("gimbal", "nadir") : take("gimbal"))} /> turn the gimbal straight down after the take-off</label>}
      <Direction survey={survey} layout={layout} />
      {number("turns_outside", "Turns may leave the area by", "m", 5, "0")}
      {number("flights", "Number of flights", "", 1, "fewest")}
      <Battery now={now} />
    </details>
  );
}

/** Rings of the area with what can be done with each. */
function Rings({ now }: { now: Studio }) {
  const rings = (now.area?.rings ?? []).filter(ring => ring.path !== null);
  if (rings.length < 2) return null;
  const isOnly = (path: Path) => rings.filter(ring => ring.what === "outer").length < 2 && Number(path.at(-1)) === 0;
  return (
    <ul class="plain rings">{rings.map(ring => (
      <li key={ring.name}>{ring.name}, {ring.places.length} corners {!isOnly(ring.path as Path) && (
        <button type="button" onClick={() => edit(`${ring.name} taken out`, { op: "take", path: ring.path as Path })}>Take {ring.name} out</button>)}</li>
    ))}</ul>
  );
}

const OWN = "by its numbers", NONE = "";

/** Photos by a camera, or plain lines. */
function Sees({ now, survey }: { now: Studio; survey: Section }) {
  const cameras = now.area?.cameras ?? [], camera = survey.camera;
  const name = typeof camera === "string" ? cameras.find(one => one.toLowerCase() === camera.toLowerCase()) ?? camera : camera ? OWN : NONE;
  const change = (chosen: string) => {
    const gone = (...keys: string[]) => keys.filter(key => (survey as Record<string, unknown>)[key] != null).map(take);
    if (chosen === NONE) {
      const height = layoutOf(now)?.height[0] ?? 40, spacing = layoutOf(now)?.spacing ?? 20;
      edit("no camera", ...gone("camera", "gsd_cm", "front_overlap", "side_overlap"), ...(survey.line_spacing == null ? [put("line_spacing", Math.max(1, Math.floor(spacing)))] : []), ...(survey.height_above_ground == null ? [put("height_above_ground", Math.round(height))] : []));
    } else {
      edit(`camera: ${chosen}`, put("camera", chosen === OWN ? { sensor_mm: [23.5, 15.6], focal_length_mm: 16, pixels: [6000, 4000] } : chosen), ...(survey.side_overlap == null ? gone("line_spacing") : []));
    }
  };
  const table = typeof camera === "object" && camera ? camera : null;
  return (
    <>
      <label class="field"><span>It sees by</span>
        <select value={name} onChange={event => change(event.currentTarget.value)}>
          <option value={NONE}>lines, no camera</option>
          {cameras.map(one => <option key={one} value={one}>{one}</option>)}
          <option value={OWN}>another camera</option>
          {typeof camera === "string" && !cameras.includes(name) && <option value={name}>{name}</option>}
        </select></label>
      {table && ([["sensor_mm", 0, "Sensor's width", "mm"], ["sensor_mm", 1, "Sensor's height", "mm"], ["focal_length_mm", null, "Focal length", "mm"], ["pixels", 0, "Photo's width", "pixels"], ["pixels", 1, "Photo's height", "pixels"]] as [string, number | null, string, string][]).map(([key, n, label, unit]) => {
        const path: Path = n === null ? ["survey", "camera", key] : ["survey", "camera", key, n];
        return <NumberInput key={label} label={label} unit={unit} step="any" value={valueAt(now.document!.scenario, path) as number ?? null}
          change={value => value !== null && edit(`${label.toLowerCase()} changed`, { op: "put", path, value })} />;
      })}
    </>
  );
}

/** How high, or how fine a pixel is on the ground: the one follows from the other. */
function HeightOrDetail({ survey, layout }: { survey: Section; layout: SurveyLayout | null }) {
  const isDetail = survey.gsd_cm != null, key = isDetail ? "gsd_cm" : "height_above_ground";
  const swap = (detail: boolean) => detail !== isDetail && edit(detail ? "detail in place of height" : "height in place of detail", take(key),
    detail ? put("gsd_cm", 3) : put("height_above_ground", Math.round(layout?.height[0] ?? 40)));
  return (
    <div class="field height">
      <label><span>{isDetail ? "Pixel on the ground" : "Height above ground"}</span></label>
      <NumberInput bare label={isDetail ? "Pixel on the ground" : "Height above ground"} step={isDetail ? 0.5 : 5} value={survey[key] ?? null} change={value => value !== null && edit(`${isDetail ? "pixel on the ground" : "height"} changed`, put(key, value))} />
      <select aria-label="Height or detail" value={key} onChange={event => swap(event.currentTarget.value === "gsd_cm")}>
        <option value="height_above_ground">m high</option><option value="gsd_cm">cm a pixel</option></select>
    </div>
  );
}

function Percent({ label, of, survey }: { label: string; of: "front_overlap" | "side_overlap"; survey: Section }) {
  const value = survey[of] == null ? null : Math.round(survey[of]! * 1000) / 10;
  return <NumberInput label={label} unit="%" step={5} unset={String(OVERLAP)} value={value} about={SURVEY_HELP[of] ?? ""}
    change={given => edit(`${label.toLowerCase()} changed`, given === null ? take(of) : put(of, Math.round(given * 10) / 1000))} />;
}

/** The quickest direction, so many degrees, or a pass across as well. */
function Direction({ survey, layout }: { survey: Section; layout: SurveyLayout | null }) {
  const given = survey.direction_deg ?? "best", now = typeof given === "number" ? "number" : Array.isArray(given) ? "list" : String(given);
  const swap = (how: string) => edit("direction changed", how === "number" ? put("direction_deg", Math.round(layout?.degrees ?? 0)) : put("direction_deg", how));
  return (
    <>
      <label class="field"><span>Direction of the lines</span>
        <select value={now} onChange={event => swap(event.currentTarget.value)}>
          <option value="best">best: the quickest{now === "best" && layout ? `, ${layout.degrees.toFixed(0)}°` : ""}</option>
          <option value="number">by degrees</option><option value="crosshatch">best, and across</option>
          {now === "list" && <option value="list">{(given as number[]).map(one => `${one}°`).join(", ")}</option>}</select></label>
      {now === "number" && <NumberInput label="Clockwise from north" unit="°" step={5} value={given as number} change={value => edit("direction changed", put("direction_deg", value ?? "best"))} />}
    </>
  );
}

/** The battery by which flights are split; its energy is known of an airframe. */
function Battery({ now }: { now: Studio }) {
  const vehicle = (now.document!.scenario.vehicle ?? {}) as NonNullable<Scenario["vehicle"]>;
  const of = (path: Path, label: string, unit: string, step: number, scale = 1, unset = "") => (
    <NumberInput label={label} unit={unit} step={step} unset={unset} value={valueAt(vehicle, path) == null ? null : Math.round(Number(valueAt(vehicle, path)) * scale * 100) / 100}
      change={value => edit(`${label.toLowerCase()} changed`, value === null ? { op: "take", path: ["vehicle", ...path] } : { op: "put", path: ["vehicle", ...path], value: value / scale })} />
  );
  if (vehicle.battery == null) {
    const begin = () => edit("battery", ...(vehicle.airframe == null ? [{ op: "put" as const, path: ["vehicle", "airframe"], value: { mass_kg: 2, rotor_diameter: 0.3 } }] : []), { op: "put", path: ["vehicle", "battery"], value: { capacity_wh: 60, reserve: 0.2 } });
    return <p class="note">Without a battery there is one flight. <button type="button" onClick={begin}>Split by battery</button></p>;
  }
  return (
    <>
      {of(["battery", "capacity_wh"], "Battery", "Wh", 5)}
      {of(["battery", "reserve"], "Reserve at landing", "%", 5, 100, "20")}
      {vehicle.airframe != null && of(["airframe", "mass_kg"], "Take-off mass", "kg", 0.1)}
      {vehicle.airframe != null && of(["airframe", "rotor_diameter"], "Rotor's diameter", "m", 0.01)}
    </>
  );
}

/** The area of a map becomes one that this scenario draws. */
function ownArea(now: Studio): void {
  const parts: LngLat[][][] = [];
  for (const ring of now.area?.rings ?? []) {
    if (ring.what === "outer") parts.push([]);
    parts.at(-1)?.push(ring.places as LngLat[]);
  }
  edit("area drawn here", { op: "own_area", parts });
  set({ selected: SURVEY });
}

/** Without it there is a flight to a goal again: over the middle of the area, where the scenario has none. */
function removeSurvey(now: Studio): void {
  const scenario = now.document!.scenario as Scenario, places = now.area?.rings.flatMap(ring => ring.places as LngLat[]) ?? [];
  const height = Math.round(layoutOf(now)?.height[0] ?? 20), mean = (n: 0 | 1) => places.reduce((sum, place) => sum + place[n], 0) / Math.max(places.length, 1);
  const ends: Change[] = [];
  if (!scenario.start) ends.push({ op: "put", path: ["start"], value: { east: 0, north: 0, height_above_ground: height } });
  if (!scenario.goal) ends.push({ op: "put", path: ["goal"], value: { latitude_deg: +mean(1).toFixed(7), longitude_deg: +mean(0).toFixed(7), height_above_ground: height } });
  edit("survey removed", ...ends, { op: "take", path: SURVEY });
  set({ selected: null });
}
