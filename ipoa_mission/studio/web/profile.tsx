// Height over the way, with ground below and what stands near; the slider that flies it.
import { useEffect, useRef, useState } from "preact/hooks";
import { sampleNear } from "./along";
import type { Plan, Stop } from "./messages";
import { chooseItem, edit, hasWorld, isDragged, isMission, proved, sampleAt, set, studio, type Studio } from "./store";
import { Strip } from "./strip";
import { seconds } from "./words";

const WIDE = 1000, HIGH = 150;
const LAND = 21; // its MAV_CMD

export function Profile({ now }: { now: Studio }) {
  const plan = proved(now);
  const timer = useRef(0);
  useEffect(() => {
    if (!now.playing || !plan) return;
    let last = performance.now(), time = plan.course.times[studio.at] ?? 0;
    const rate = Math.max(1, plan.total_s / 25);
    const step = (at: number) => {
      time += ((at - last) / 1000) * rate;
      last = at;
      const index = sampleAt(plan.course, time);
      set({ at: index });
      if (index >= plan.course.times.length - 1) set({ playing: false });
      else timer.current = requestAnimationFrame(step);
    };
    timer.current = requestAnimationFrame(step);
    return () => cancelAnimationFrame(timer.current);
  }, [now.playing, plan?.proof]);
  const isTall = useRef(false);
  isTall.current ||= hasWorld(now); // a map that has been drawn stays as large as it is
  const ends = isTall.current ? " ends" : "";
  if (!plan) return <footer class={`profile empty${ends}`}><p class="note">{noProfile(now)}</p></footer>;
  const course = plan.course, at = Math.min(now.at, course.times.length - 1);
  const apart = course.apart[at];
  return (
    <footer class={`profile${ends}${isDragged(now) ? " past" : ""}`}>
      <Chart now={now} plan={plan} at={at} flown={flownOver(now, plan)} />
      <div class="slider">
        <button type="button" aria-label={now.playing ? "Pause" : "Play"} onClick={() => set({ playing: !now.playing, at: at >= course.times.length - 1 ? 0 : at })}>{now.playing ? "❚❚" : "▶"}</button>
        <input type="range" min="0" max={course.times.length - 1} value={at} aria-label="Moment of the flight"
          aria-valuetext={`${course.times[at]!.toFixed(0)} seconds`} onInput={event => set({ at: Number(event.currentTarget.value), playing: false })} />
        <output>{seconds(course.times[at]!)} · {course.line.up[at]!.toFixed(1)} m above home{isMission(now) && !now.mission?.scenario ? "" : `, ${(course.line.up[at]! - course.ground[at]!).toFixed(1)} m above ground`} · {course.speeds[at]!.toFixed(1)} m/s{apart === null || apart === undefined ? "" : ` · ${apart.toFixed(1)} m clear`}</output>
      </div>
      {hasWorld(now) ? <Strip now={now} plan={plan} at={at} /> : ends && <p class="note">How it would end there is not known: nor is what stands there.</p>}
    </footer>
  );
}

function Chart({ plan, at, flown, now }: { plan: Plan; at: number; flown: [number, number][]; now: Studio }) {
  const { along, ground, line, times } = plan.course, turns = plan.course.returns_at ?? null;
  const length = along.at(-1) || 1;
  const low = Math.min(...ground, 0), high = Math.max(...line.up) * 1.12 + 2;
  const x = (value: number) => ((value / length) * WIDE).toFixed(1);
  const y = (value: number) => (HIGH - ((value - low) / (high - low)) * HIGH).toFixed(1);
  const path = (heights: number[]) => "M" + heights.map((up, n) => `${x(along[n]!)} ${y(up)}`).join("L");
  const soil = `${path(ground)}L${WIDE} ${HIGH}L0 ${HIGH}Z`;
  const band = `${path(line.up.map(up => up + plan.required))}L${[...line.up].map((up, n) => [up, n] as const).reverse().map(([up, n]) => `${x(along[n]!)} ${y(up - plan.required)}`).join("L")}Z`;
  const step = niceStep((high - low) / 3), ticks: number[] = [];
  for (let tick = Math.ceil(low / step) * step; tick < high; tick += step) ticks.push(tick);
  const seen = flown.map(([sample, up]) => `${x(along[sample]!)} ${y(up)}`);
  const grip = useRef<{ stop: Stop; up: number } | null>(null), [held, hold] = useState<{ stop: Stop; up: number } | null>(null);
  const heightAt = (event: PointerEvent & { currentTarget: SVGSVGElement }) => {
    const box = event.currentTarget.getBoundingClientRect();
    return Math.round((low + (1 - (event.clientY - box.top) / box.height) * (high - low)) * 2) / 2;
  };
  const take = (event: PointerEvent & { currentTarget: SVGSVGElement }) => {
    const box = event.currentTarget.getBoundingClientRect(), wanted = ((event.clientX - box.left) / box.width) * WIDE;
    const stop = plan.stops.filter(one => one.up !== null && isDraggable(now, one.seq))
      .find(one => Math.abs(Number(x(along[one.at]!)) - wanted) < 8 && Math.abs(Number(y(line.up[one.at]!)) - ((event.clientY - box.top) / box.height) * HIGH) < 14);
    if (!stop) return point(event);
    event.currentTarget.setPointerCapture(event.pointerId);
    grip.current = { stop, up: stop.up! };
    chooseItem(stop.seq);
  };
  const pull = (event: PointerEvent & { currentTarget: SVGSVGElement }) => {
    if (!event.buttons) return;
    if (!grip.current) return point(event);
    grip.current = { ...grip.current, up: heightAt(event) };
    hold(grip.current);
  };
  const drop = () => {
    const done = grip.current;
    grip.current = null;
    hold(null);
    const item = now.mission?.items.find(one => one.seq === done?.stop.seq);
    if (!done || !item || Math.abs(done.up - done.stop.up!) < 0.25) return;
    const value = Math.round(((item.values[6] ?? 0) + done.up - done.stop.up!) * 100) / 100;
    edit(`item ${item.seq}: height ${value} m`, { op: "put_item", seq: item.seq, what: "param7", value });
  };
  const point = (event: PointerEvent & { currentTarget: SVGSVGElement }) => {
    const box = event.currentTarget.getBoundingClientRect();
    const wanted = ((event.clientX - box.left) / box.width) * length;
    set({ at: Math.max(0, along.findIndex(value => value >= wanted)), playing: false });
  };
  return (
    <div class="chart">
      {ticks.map(tick => <span class="tick" key={tick} style={{ top: `${(Number(y(tick)) / HIGH) * 100}%` }}>{tick} m</span>)}
      <svg viewBox={`0 0 ${WIDE} ${HIGH}`} preserveAspectRatio="none" role="img" aria-label={`Height over the way: ${length.toFixed(0)} m, up to ${Math.max(...line.up).toFixed(0)} m above home`}
        onPointerDown={take} onPointerMove={pull} onPointerUp={drop} onPointerCancel={() => { grip.current = null; hold(null); }}>
        {ticks.map(tick => <path key={tick} class="grid" d={`M0 ${y(tick)}H${WIDE}`} />)}
        {plan.nearby.map((body, n) => {
          const left = Math.max(0, body.begins - 0.002 * length), right = Math.min(length, body.ends + 0.002 * length);
          const top = Math.min(body.top, high), base = Math.max(body.base, low);
          return <path key={n} class={body.look} d={`M${x(left)} ${y(base)}V${y(top)}H${x(right)}V${y(base)}Z`}><title>{body.look === "zone" ? `${body.name}: no-fly zone` : `${body.name}: ${body.base.toFixed(0)} to ${body.top.toFixed(0)} m`}</title></path>;
        })}
        <path class="soil" d={soil} />
        <path class="band" d={band} />
        <path class="planned" d={path(turns === null ? line.up : line.up.slice(0, turns + 1))} />
        {turns !== null && <path class="planned home" d={"M" + line.up.slice(turns).map((up, n) => `${x(along[turns + n]!)} ${y(up)}`).join("L")} />}
        {seen.length > 1 && <path class="flown" d={`M${seen.join("L")}`} />}
        {plan.stops.map(stop => <path key={stop.seq} class={stop.seq === now.item ? "mark chosen" : "mark"} d={`M${x(along[stop.at]!)} ${y(line.up[stop.at]!)}v${stop.seq === now.item ? 14 : 6}`} />)}
        {plan.stops.filter(stop => stop.up !== null && isDraggable(now, stop.seq)).map(stop => <path key={`grip ${stop.seq}`} class="grip" d={`M${x(along[stop.at]!)} ${y(held?.stop.seq === stop.seq ? held.up : line.up[stop.at]!)}h0.01`} />)}
        <path class="cursor" d={`M${x(along[at]!)} 0V${HIGH}`} />
      </svg>
      {held && <span class="unit held">item {held.stop.seq}: {held.up.toFixed(1)} m above home</span>}
      <span class="unit">{times.length ? `${length.toFixed(0)} m` : ""}</span>
    </div>
  );
}

/** An item of an open mission whose height is its own: not one of a survey, no landing. */
function isDraggable(now: Studio, seq: number): boolean {
  const item = isMission(now) ? now.mission?.items.find(one => one.seq === seq) : undefined;
  return item !== undefined && !item.part_of && item.place !== null && item.command !== LAND;
}

function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map(k => k * power).find(step => step >= value) ?? value;
}

/** Flown heights over the samples of the course that the places are nearest to: who holds or is late stays there. */
function flownOver({ replay, loaded, flown }: Studio, plan: Plan): [number, number][] {
  const live = loaded?.mission === plan.name ? flown : [];
  const places = replay ? replay.line.points : live.map(seen => seen.place), heights = replay ? replay.line.up : live.map(seen => seen.up);
  let at = 0;
  return places.map((place, n) => [at = sampleNear(plan.course, place, at), heights[n]!]);
}

/** Why there is no profile, or when it comes. */
function noProfile({ checked, document, ...now }: Studio): string {
  if (!isMission({ checked, document, ...now })) return "The height profile comes with the proved path.";
  if (checked?.revision !== document?.revision || checked?.timeless == null) return "The height profile comes with the check.";
  return `No height profile: ${checked.timeless}.`;
}
