// The first thing that one wants to know: is it clear, is that proved, how long will it fly; and what is being done.
import { useEffect, useRef } from "preact/hooks";
import { showNamed } from "./map";
import type { Trouble } from "./messages";
import { MissionVerdict } from "./mission";
import { blocking, coarseOf, edit, isMission, isSurvey, proved, send, studio, type Studio } from "./store";
import { SurveyFigures, SurveyVerdict } from "./survey";
import { meters, seconds, share } from "./words";

/** Whether it is about what lies on the map. */
const isOfPlan = (trouble: Trouble): boolean => ["scenario", "sketch", "plan"].includes(trouble.of);

export function Verdict({ now }: { now: Studio }) {
  const refusals = blocking(now), others = now.troubles.filter(one => !isOfPlan(one));
  const plan = proved(now), coarse = coarseOf(now), place = useRef<HTMLElement>(null);
  const first = refusals[0]?.message;
  useEffect(() => { if (first) place.current?.scrollIntoView({ block: "nearest" }); }, [first]);
  return (
    <section class={isMission(now) ? "verdict" : "verdict steady"} aria-live="polite" ref={place}>
      {isMission(now) ? (refusals.length ? <Troubles of={refusals} /> : <MissionVerdict now={now} checked={now.checked?.revision === now.document?.revision ? now.checked : null} />)
        : refusals.length && !now.drag && !now.dragSurvey ? <Troubles of={refusals} />
        : isSurvey(now) ? <SurveyVerdict now={now} />
        : plan && !now.drag ? (
          <p class={plan.warnings.length ? "amber" : "good"}><b aria-hidden="true">{plan.warnings.length ? "!" : "✓"}</b> Proved. {
            plan.kept === null ? <>{plan.verdict}.</>
              : plan.confidence !== null ? <>{share(plan.confidence)} of flights keep {meters(plan.kept, 2)} from {plan.nearest} (predicted {
                meters(plan.nominal!, 2)}); {meters(plan.required, 2)} required.</>
                : <>Predicted {meters(plan.kept, 2)} from {plan.nearest}; {meters(plan.required, 2)} required.</>}
            {plan.warnings.length > 0 && <> But read before you fly: {plan.warnings[0]}{plan.warnings.length > 1 && `, and ${plan.warnings.length - 1} more`}.</>}</p>
        ) : coarse ? (
          <p class={coarse.is_proved ? "coarse" : "bad"}><b aria-hidden="true">{coarse.is_proved ? "≈" : "✕"}</b> {now.drag ? "While you drag: a" : "A"} coarse
            path{coarse.is_proved ? `, ${meters(coarse.clearance, 2)} from ${coarse.nearest}` : ` breaks a limit: ${coarse.verdict}`}.
            {coarse.is_proved ? " Not yet the best one, and its deviation bound is not proved." : " The planner may still find a way."}</p>
        ) : <p class="coarse">Looking at the scenario …</p>}
      {now.progress && !plan && (
        <div class="progress">
          <progress max="1" value={now.progress.share} aria-label="planning" />
          <span>{now.progress.words}</span>
          <button type="button" onClick={() => send({ kind: "do", what: "cancel" })}>Cancel</button>
        </div>
      )}
      {isSurvey(now) ? <SurveyFigures now={now} /> : <Figures now={now} />}
      <Troubles of={others} />
    </section>
  );
}

function Troubles({ of }: { of: Trouble[] }) {
  return <>{of.map(trouble => (
    <div key={trouble.of} class="trouble">
      <ul class="refusal">{trouble.message.split("\n").map(line => <li key={line}><b aria-hidden="true">✕</b> {line}</li>)}</ul>
      {trouble.hint && !trouble.remedies?.length && <p class="note">Try: {trouble.hint}</p>}
      <p class="remedies">
        {trouble.remedies?.map(remedy => <button type="button" key={remedy.label} onClick={() => edit(remedy.label, ...remedy.changes)}>{remedy.label}</button>)}
        {trouble.of === "scenario" && studio.document?.undo && <button type="button" onClick={() => send({ kind: "do", what: "undo" })}>Undo: {studio.document.undo}</button>}
        {isOfPlan(trouble) && <button type="button" onClick={() => showNamed(trouble)}>Show on the map</button>}
        {trouble.of === "plan" && <button type="button" onClick={() => send({ kind: "do", what: "plan" })}>Plan again</button>}</p>
    </div>
  ))}</>;
}

/** What flights keep, or how far inside of something they come. */
const keeps = (kept: number): string => (kept < 0 ? `${meters(-kept, 2)} inside` : meters(kept, 2));

function Figures({ now }: { now: Studio }) {
  const plan = proved(now), coarse = coarseOf(now);
  if (plan && !now.drag) {
    return (
      <dl class="figures">
        <div><dt>flight</dt><dd>{seconds(plan.total_s)}<small>{seconds(plan.low_s)} to {seconds(plan.high_s)}</small></dd></div>
        {plan.required > 0 && <div><dt>{plan.confidence === null ? "predicted clearance" : "flights keep"}</dt><dd>{plan.kept === null ? "–" : keeps(plan.kept)}<small>{meters(plan.required, 2)} required</small></dd></div>}
        <div><dt>path</dt><dd>{meters(plan.length, 0)}</dd></div>
        {plan.energy_wh !== null && <div><dt>energy</dt><dd>{plan.energy_wh.toFixed(1)} Wh<small>{plan.battery_left === null ? "" : `${share(plan.battery_left)} left`}</small></dd></div>}
      </dl>
    );
  }
  if (!coarse) return null;
  return (
    <dl class="figures rough">
      <div><dt>route, at least</dt><dd>{seconds(coarse.seconds)}<small>a lower bound</small></dd></div>
      <div><dt>coarse path's clearance</dt><dd>{meters(coarse.clearance, 2)}<small>to {coarse.nearest}</small></dd></div>
      <div><dt>path</dt><dd>{meters(coarse.length, 0)}</dd></div>
    </dl>
  );
}
