// What this window knows: the latest answer of each kind, and what the user is at. One object, replaced as it changes.
import { sampleNear } from "./along";
import type { Answer, Beginning, Checked, CoarseSurvey, Course, Document, Edit, Found, Heard, Landed, Loaded, OpenMission, Plan, PlannedSurvey, Put, Progress, Replay, Request, Seen, Sketch, State, ContingencyStrip, SurveyArea, SurveyLayout, SurveyLine, Tiles, Trouble, World } from "./messages";
import { connect } from "./link";
import { changed, chosenAsShown, shows, waits, waitsBehind } from "./numbers";

export type Change = Edit["changes"][number];
export type Path = Put["path"];
export type LngLat = [number, number];

export type Tool = "select" | "measure" | "waypoint" | "via" | "box" | "polygon" | "cylinder" | "keep-out" | "keep-in" | "rally" | "area" | "hole" | "corridor";

export interface Candidate {
  name: string;
  plan: Plan;
  text: string;
}

export interface Studio {
  connected: boolean;
  document: Document | null;
  world: World | null;
  tiles: Tiles | null;
  picture: boolean;
  sketch: Sketch | null;
  drag: Sketch | null;
  plan: Plan | null;
  area: SurveyArea | null;
  coarseSurvey: CoarseSurvey | null;
  dragSurvey: CoarseSurvey | null;
  survey: PlannedSurvey | null;
  /** How the plan's flights can end, flight by flight: they come after it. */
  contingencies: Record<number, ContingencyStrip>;
  /** Which flight of a survey is looked at, from 0 on, and those that were flown from here, by name. */
  part: number;
  flownParts: string[];
  /** A place of a survey that was asked for: a gap, the smallest overlap. */
  lookedAt: LngLat | null;
  mission: OpenMission | null;
  checked: Checked | null;
  replay: Replay | null;
  start: Beginning | null;
  heard: Heard | null;
  found: Found | null;
  homeward: boolean;
  whole: boolean;
  progress: Progress | null;
  troubles: Trouble[];
  tool: Tool;
  selected: Path | null;
  space: boolean;
  at: number;
  item: number | null;
  playing: boolean;
  candidates: Candidate[];
  loaded: Loaded | null;
  seen: Seen | null;
  flown: Seen[];
  landed: Landed | null;
  flight: State | null;
  notice: string;
  /** What is said to who does not see the map. */
  spoken: string;
  dropped: Dropped | null;
}

/** A file that was dropped, and is kept beside the scenario. */
export interface Dropped {
  kind: "map" | "elevation" | "mission" | "log";
  path?: string;
  file: string;
  changes: Change[];
}

export let studio: Studio = {
  connected: false, document: null, world: null, tiles: null, picture: true, sketch: null, drag: null, plan: null, progress: null, troubles: [],
  area: null, coarseSurvey: null, dragSurvey: null, survey: null, contingencies: {}, part: 0, flownParts: [], lookedAt: null,
  mission: null, checked: null, replay: null, start: null, heard: null, found: null, homeward: false, whole: false,
  tool: "select", selected: null, space: false, at: 0, item: null, playing: false, candidates: [], loaded: null, seen: null,
  flown: [], landed: null, flight: null, notice: "", spoken: "", dropped: null,
};

/** The path to the survey: what is chosen when its area is. */
export const SURVEY: Path = ["survey"];

type Listener = (now: Studio, before: Studio) => void;
const listeners = new Set<Listener>();

export function listen(listener: Listener): void {
  listeners.add(listener);
}

export function set(change: Partial<Studio>): void {
  const before = studio;
  studio = { ...studio, ...change };
  for (const listener of listeners) listener(studio, before);
}

/** A server that comes back numbers its revisions anew: what an earlier one proved counts no more; it tells what it has. */
const FORGOTTEN = { sketch: null, drag: null, plan: null, contingencies: {}, area: null, coarseSurvey: null, dragSurvey: null, survey: null, mission: null, checked: null, replay: null, progress: null, troubles: [], loaded: null, flight: null };

const link = connect(hear, connected => {
  shows(undefined, true);
  set({ connected, ...(connected ? FORGOTTEN : {}) });
});

export function send(request: Request): void {
  if (request.kind !== "do" || !waitsBehind(() => send(request))) link.send(request);
}

const shownRevision = (now: Studio): number | undefined => (isMission(now) ? now.mission : now.document)?.revision;

/** Change the file; every window is told. A mission's items are meant by the numbers that are shown. */
export function edit(label: string, ...changes: Change[]): void {
  const seen = shownRevision(studio);
  if (seen === undefined || waits(() => edit(label, ...changes))) return;
  send({ kind: "edit", seen, label, changes });
  changed(seen, changes);
}

/** Whether a mission file is open, and no scenario. */
export const isMission = (now: Studio): boolean => now.document?.of === "mission";

let asked = 0;
let waiting: Change[] | null = null;
let awaited = false;
let dragging = false;

/** Ask how it would be. One question is under way at a time; of those that come meanwhile the last is asked next. */
export function drag(changes: Change[]): void {
  dragging = true;
  if (awaited) {
    waiting = changes;
    return;
  }
  awaited = true;
  send({ kind: "drag", number: ++asked, changes });
}

export function endDrag(): void {
  waiting = null;
  dragging = false;
  set({ drag: null, dragSurvey: null, troubles: studio.troubles.filter(one => one.of !== "sketch") });
}

function dragAnswered(): void {
  awaited = false;
  if (waiting) {
    const next = waiting;
    waiting = null;
    drag(next);
  }
}

function hear(answer: Answer): void {
  take(answer);
  const isRefused = answer.kind === "trouble" && answer.of !== "flight", isBehind = isMission(studio) && studio.mission?.revision !== studio.document?.revision;
  if (isRefused || !isBehind) shows(shownRevision(studio), isRefused);
}

function take(answer: Answer): void {
  switch (answer.kind) {
    case "document":
      document.title = `${answer.unsaved ? "● " : ""}${answer.name} · studio`;
      if (answer.revision !== studio.document?.revision) set({ progress: null, troubles: [], drag: null, dragSurvey: null, lookedAt: null });
      set({ document: answer, ...(studio.document ? {} : { candidates: keptCandidates(answer.path) }) });
      break;
    case "tiles":
      set({ tiles: answer });
      break;
    case "world":
      set({ world: answer });
      break;
    case "sketch":
      if (answer.number !== null) {
        dragAnswered();
        if (dragging) set({ drag: answer });
      } else {
        set({ sketch: answer });
      }
      break;
    case "area":
      set({ area: answer });
      break;
    case "coarse_survey":
      if (answer.number === null) {
        set({ coarseSurvey: answer });
      } else {
        dragAnswered();
        if (dragging) set({ dragSurvey: answer });
      }
      break;
    case "survey": {
      const part = Math.min(studio.part, answer.flights.length - 1);
      set({ survey: answer, contingencies: {}, part, progress: null, troubles: studio.troubles.filter(one => one.of !== "plan"), flownParts: [], at: Math.min(studio.at, answer.flights[part]!.plan.course.times.length - 1) });
      break;
    }
    case "progress":
      set({ progress: answer, troubles: studio.troubles.filter(one => one.of !== "plan") });
      break;
    case "plan":
      set({ plan: answer, contingencies: {}, progress: null, troubles: studio.troubles.filter(one => one.of !== "plan"), at: Math.min(studio.at, answer.course.times.length - 1) });
      break;
    case "contingencies":
      set({ contingencies: { ...studio.contingencies, [answer.flight]: answer } });
      break;
    case "mission":
      set({ mission: answer, item: studio.item !== null && studio.item > answer.items.length ? null : studio.item });
      break;
    case "checked":
      set({ checked: answer, ...(answer.timeless === null ? {} : { plan: null, replay: null }) });
      break;
    case "replay":
      set({ replay: answer });
      break;
    case "beginning":
      document.title = "studio";
      set({ start: answer });
      break;
    case "heard":
      set({ heard: answer });
      break;
    case "found":
      set({ found: answer });
      break;
    case "redirect":
      location.assign(new URL(answer.address, document.baseURI));
      break;
    case "trouble":
      if (answer.of === "sketch" && awaited) dragAnswered();
      set({ troubles: [...studio.troubles.filter(one => one.of !== answer.of), answer] });
      if (answer.of === "plan") set({ progress: null });
      if (answer.fences?.length && studio.world) set({ world: { ...studio.world, fences: answer.fences } });
      break;
    case "loaded":
      set({ loaded: answer, landed: null, flown: [], seen: null });
      break;
    case "seen":
      set({ seen: answer, flown: [...studio.flown, answer], ...following(answer) });
      break;
    case "landed":
      set({ landed: answer, ...(answer.completed && studio.loaded ? { flownParts: [...studio.flownParts, studio.loaded.mission] } : {}) });
      break;
    case "state":
      if (answer.phase === "uploading") set({ troubles: studio.troubles.filter(one => one.of !== "flight") });
      set({ flight: answer });
      break;
    case "written":
      set({ notice: [`written: ${answer.files.join(", ")}`, ...answer.remarks ?? []].join("; ") });
      break;
  }
}

const keyOf = (path: string) => `candidates of ${path}`;

/** The plans that were kept of a scenario in this browser. */
function keptCandidates(path: string): Candidate[] {
  try {
    return JSON.parse(localStorage.getItem(keyOf(path)) ?? "[]") as Candidate[];
  } catch {
    return [];
  }
}

/** Keep plans beside each other, also for when the page is opened again. */
export function keepCandidates(candidates: Candidate[]): void {
  set({ candidates });
  try {
    localStorage.setItem(keyOf(studio.document!.path), JSON.stringify(candidates.map(one => ({ ...one, plan: { ...one.plan, homeward: [] } }))));
  } catch {
    set({ notice: "This browser has no room to keep it: it is gone when the page is closed." });
  }
}

/** An item of the mission is chosen: in the list, on the map and in the profile alike. */
export function chooseItem(seq: number): void {
  const stop = proved(studio)?.stops.find(one => one.seq === seq);
  chosenAsShown();
  set({ item: seq, playing: false, ...(stop ? { at: stop.at } : {}) });
}

/** The coarse path to show: of a drag, or of the scenario as it is now; never one of an earlier scenario. */
export function coarseOf(now: Studio): Sketch | null {
  return now.drag ?? (now.sketch && now.sketch.revision === now.document?.revision ? now.sketch : null);
}

/** Whether what is shown is of no plan yet, since something is held in the hand. */
export const isDragged = (now: Studio): boolean => now.drag !== null || now.dragSurvey !== null;

/** What there can be no proved path with: what is not understood first, then what the planner says, then the coarse look. */
export function blocking(now: Studio): Trouble[] {
  const found = now.troubles.filter(one => one.of === "scenario" || one.of === "sketch" || one.of === "plan");
  const first = (["scenario", "plan", "sketch"] as const).find(of => found.some(one => one.of === of));
  return found.filter(one => one.of === first);
}

/** Whether a thing of the map is named in what is refused. */
export function isNamed(name: string, refusals: Trouble[]): boolean {
  const word = (letter: string | undefined) => letter !== undefined && /[\p{L}\p{N}]/u.test(letter);
  return refusals.some(({ message, of_home }) => {
    if (name === "home") return of_home === true; // in words it is what heights count from
    const at = message.indexOf(name);
    return at >= 0 && !word(message[at - 1]) && !word(message[at + name.length]);
  });
}

/** Whether the scenario that is open sees an area. */
export const isSurvey = (now: Studio): boolean => now.document?.scenario.survey !== undefined;

/** Whether the scenario says where a place is: a survey begins and ends over home unless something else is said. */
export const isWritten = (path: Path): boolean =>
  isMission(studio) || (path[0] !== "start" && path[0] !== "goal") || studio.document?.scenario[path[0]] !== undefined;

/** The flights of a survey, if they are of the scenario as it is now. */
export function surveyed(now: Studio): PlannedSurvey | null {
  return now.survey && now.survey.revision === now.document?.revision ? now.survey : null;
}

/** Plan what a log, with those before, has left of a survey; without one all of it again. */
export function planRest(now: Studio, log: string | null): void {
  send({ kind: "rest", logs: log === null ? [] : [...new Set([...surveyed(now)?.flown ?? [], log])] });
}

/** The lines that no flight flies yet, where they are what is to be shown: of a drag, or while flights are planned. */
export function coarseSurveyOf(now: Studio): CoarseSurvey | null {
  if (now.dragSurvey) return now.dragSurvey;
  return !surveyed(now) && now.coarseSurvey && now.coarseSurvey.revision === now.document?.revision ? now.coarseSurvey : null;
}

/** The lines to be shown. */
export const layoutOf = (now: Studio): SurveyLayout | null => coarseSurveyOf(now)?.layout ?? surveyed(now)?.layout ?? null;

/** Look at another flight of a survey, from its begin. */
export function choosePart(part: number): void {
  set({ part, at: 0, item: null, playing: false });
}

/** The slider goes with the vehicle whose plan is shown, from the first that is seen of it until somebody moves it. */
let followed = 0;
function following(seen: Seen): Partial<Studio> {
  const plan = proved(studio);
  if (!plan || studio.playing || studio.replay || studio.loaded?.mission !== plan.name) return {};
  if (studio.flown.length && studio.at !== followed) return {};
  followed = sampleNear(plan.course, seen.place, studio.flown.length ? followed : 0);
  return { at: followed };
}

/** The photo of the chosen flight that is taken nearest to where the slider stands, with its line. */
export function photoAt(now: Studio): { line: SurveyLine; place: LngLat } | null {
  const here = proved(now)?.course.line.points[now.at], [wide, high] = now.world?.degree_m ?? [1, 1];
  let best: { line: SurveyLine; place: LngLat } | null = null, least = Infinity;
  for (const line of here ? surveyed(now)?.layout.lines ?? [] : []) {
    if (line.flight !== now.part) continue;
    for (const place of line.photos as LngLat[]) {
      const away = Math.hypot((place[0] - here![0]!) * wide!, (place[1] - here![1]!) * high!);
      if (away < least) [best, least] = [{ line, place }, away];
    }
  }
  return least <= (surveyed(now)?.layout.trigger ?? 0) ? best : null;
}

/** The plan, if it is of the scenario as it is now, of a survey that of the chosen flight; of a mission the last one. */
export function proved(now: Studio): Plan | null {
  const survey = surveyed(now);
  if (survey) return survey.flights[Math.min(now.part, survey.flights.length - 1)]!.plan;
  if (isMission(now)) return now.plan?.of === "mission" ? now.plan : null;
  return now.plan && now.document && now.plan.revision === now.document.revision ? now.plan : null;
}

/** As it was when a plan was last proved, while there is none of what is here now: what stands at the side stays there, faded. */
export function asLastProved(now: Studio): Studio {
  const revision = isSurvey(now) ? now.survey?.revision : now.plan?.revision;
  return !now.document || isMission(now) || revision === undefined || proved(now) ? now : { ...now, document: { ...now.document, revision } };
}

/** Whether it is known what stands where the flight goes. */
export const hasWorld = (now: Studio): boolean => !isMission(now) || Boolean(now.mission?.scenario);

/** How the flight that is looked at can end, once that is known. */
export function contingenciesOf(now: Studio): ContingencyStrip | null {
  const plan = proved(now), strip = now.contingencies[surveyed(now) ? now.part : 0];
  return plan && strip?.revision === plan.revision ? strip : null;
}

/** The sample of a course at which it has been under way for so long. */
export function sampleAt(course: Course, time: number): number {
  let low = 0, high = course.times.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (course.times[middle]! < time) low = middle + 1;
    else high = middle;
  }
  return low;
}
