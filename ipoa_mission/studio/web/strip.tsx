// What each way to end the flight would do, second by second, under the profile: bars in colors, and words.
import { useState } from "preact/hooks";
import type { Course, Plan, StripBar, StripCost, ContingencyStrip, StripStretch } from "./messages";
import { contingenciesOf, sampleAt, set, type Studio } from "./store";
import { share } from "./words";

/** What is pointed at: a contingency, and the sample of the course; null: the one at which the slider stands. */
interface Pointed {
  contingency: string;
  at: number | null;
}

export function Strip({ now, plan, at }: { now: Studio; plan: Plan; at: number }) {
  const [pointed, point] = useState<Pointed | null>(null), [focused, focus] = useState<string | null>(null);
  const strip = contingenciesOf(now), { course } = plan;
  if (!strip?.bars.length) return <div class="strip"><p class="note">{strip ? "How it would end there is not known." : "How it would end there is being worked out …"}</p></div>;
  const time = course.times[at]!;
  const told = strip.bars.find(bar => bar.contingency === (pointed?.contingency ?? focused)) ?? worst(strip.bars, time);
  return (
    <div class="strip" role="group" aria-label="If it were ended there">
      {strip.bars.map(bar => (
        <Row key={bar.contingency} bar={bar} course={course} at={at} words={sentence(strip, bar, time)} point={point} focus={focus} />
      ))}
      <p class="then"><b>{told.contingency}</b> {sentence(strip, told, course.times[pointed?.at ?? at]!)}</p>
      <ul class="hidden">{strip.bars.flatMap(bar => bar.stretches.map(one => <li key={bar.contingency + one.from_s}>{bar.contingency} {spanned(one)}</li>))}</ul>
    </div>
  );
}

function Row({ bar, course, at, words, point, focus }: { bar: StripBar; course: Course; at: number; words: string; point: (to: Pointed | null) => void; focus: (contingency: string | null) => void }) {
  const length = course.along.at(-1) || 1, last = course.times.length - 1;
  const left = (along: number) => `${((100 * along) / length).toFixed(2)}%`;
  const under = (event: PointerEvent & { currentTarget: HTMLElement }) => {
    const box = event.currentTarget.getBoundingClientRect(), wanted = ((event.clientX - box.left) / box.width) * length;
    const found = course.along.findIndex(value => value >= wanted);
    return found < 0 ? last : found;
  };
  const go = (sample: number) => set({ at: Math.min(last, Math.max(0, sample)), playing: false });
  const press = (event: KeyboardEvent) => {
    const to = moved(event.key, bar, course, at);
    if (to === null || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation(); // Home is also the map's
    go(to);
  };
  return (
    <div class="row" role="slider" tabIndex={0} data-contingency={bar.contingency} aria-label={`${bar.contingency}, if it were ended there`} aria-valuemin={0} aria-valuemax={last} aria-valuenow={at} aria-valuetext={words}
      onFocus={() => focus(bar.contingency)} onBlur={() => focus(null)} onKeyDown={press}>
      <b>{bar.contingency}</b>
      <div class="ways" onPointerLeave={() => point(null)}
        onPointerDown={event => go(under(event))}
        onPointerMove={event => { const sample = under(event); point({ contingency: bar.contingency, at: event.pointerType === "mouse" ? sample : null }); if (event.buttons) go(sample); }}>
        {bar.stretches.map(one => (
          <span key={one.from_s} class={`way ${one.look.replace(" ", "-")}`} title={spanned(one)} style={{ left: left(one.begins), width: left(one.ends - one.begins) }}><span>{one.look}</span></span>
        ))}
        <i class="cursor" style={{ left: left(course.along[at]!) }} />
      </div>
    </div>
  );
}

/** The sample to which a key leads: a step, or to where what the contingency would do changes. */
function moved(key: string, bar: StripBar, course: Course, at: number): number | null {
  const time = course.times[at]!, begins = bar.stretches.map(one => sampleAt(course, one.from_s));
  switch (key) {
    case "ArrowRight": case "ArrowUp": return at + 1;
    case "ArrowLeft": case "ArrowDown": return at - 1;
    case "Home": return 0;
    case "End": return course.times.length - 1;
    case "PageUp": return begins.find(one => one > at) ?? sampleAt(course, Math.max(time, bar.stretches.at(-1)!.to_s));
    case "PageDown": return begins.findLast(one => one < at) ?? 0;
    default: return null;
  }
}

const spanned = (one: StripStretch): string => `${one.from_s.toFixed(1)} to ${one.to_s.toFixed(1)} s, ${one.words}`;

/** Which stretch of a contingency a moment lies in; null: the vehicle is on the ground. */
function stretchAt(bar: StripBar, time: number): StripStretch | null {
  if (time < bar.stretches[0]!.from_s) return null;
  return bar.stretches.find(one => time < one.to_s) ?? (time === bar.stretches.at(-1)!.to_s ? bar.stretches.at(-1)! : null);
}

const WORSE: StripStretch["look"][] = ["clear", "perhaps", "unknown", "not clear"];

/** The contingency that is worst at a moment; of those that are as bad the first. */
function worst(bars: StripBar[], time: number): StripBar {
  const bad = (bar: StripBar) => WORSE.indexOf(stretchAt(bar, time)?.look ?? "clear");
  return bars.reduce((one, other) => (bad(other) > bad(one) ? other : one));
}

/** What a contingency would do at a moment. */
function sentence(strip: ContingencyStrip, bar: StripBar, time: number): string {
  const stretch = stretchAt(bar, time), cost = stretch && costAt(bar.costs, time);
  const words = `at ${time.toFixed(1)} s${stretch ? ` ${stretch.words}` : ": it is on the ground"}`;
  if (!cost) return words;
  const energy = cost.energy_wh ? ` and ${between(cost.energy_wh, 1)} Wh` : "";
  const takes = `${words}; takes ${between(cost.seconds, 0)} s${energy}`;
  if (cost.lands === null || strip.reserve === null) return takes;
  const lands = `lands with ${share(cost.lands)} (${share(cost.least!)} to ${share(cost.most!)}) of its battery`;
  return `${takes}, ${lands}, ${share(strip.reserve)} required${cost.lands < strip.reserve ? ": not enough" : ""}`;
}

const between = ([low, high]: [number, number], digits: number): string =>
  low.toFixed(digits) === high.toFixed(digits) ? low.toFixed(digits) : `${low.toFixed(digits)} to ${high.toFixed(digits)}`;

/** What a contingency takes at a moment: what lies between the two that are known beside it. */
function costAt(costs: StripCost[], time: number): StripCost | null {
  const after = costs.findIndex(one => one.at_s >= time), next = costs.at(after);
  if (!next) return null;
  const last = after > 0 ? costs[after - 1]! : next;
  const part = next.at_s > last.at_s ? Math.min(1, (time - last.at_s) / (next.at_s - last.at_s)) : 0;
  const mixed = (one: number, other: number) => one + part * (other - one);
  const pair = (one: [number, number], other: [number, number]): [number, number] => [mixed(one[0], other[0]), mixed(one[1], other[1])];
  const maybe = (one: number | null, other: number | null) => (one === null || other === null ? null : mixed(one, other));
  return {
    at_s: time, seconds: pair(last.seconds, next.seconds),
    energy_wh: last.energy_wh && next.energy_wh && pair(last.energy_wh, next.energy_wh),
    lands: maybe(last.lands, next.lands), least: maybe(last.least, next.least), most: maybe(last.most, next.most),
  };
}
