// What is known of a mission file that is open: what the check finds, how long it flies, in whose world; and its log.
import type { Checked, Finding, Plan } from "./messages";
import { chooseItem, isMission, proved, send, type Studio } from "./store";
import { meters, seconds, share } from "./words";

const MOST = 6; // findings that are shown at once

export function MissionVerdict({ now, checked }: { now: Studio; checked: Checked | null }) {
  const plan = proved(now);
  if (!checked) return <p class="coarse">Looking at the mission …</p>;
  const errors = checked.flaws.filter(flaw => flaw.severity === "error"), warnings = checked.flaws.length - errors.length;
  const isUnsure = warnings > 0 || !now.mission?.scenario;  // nothing is green of which no clearance is known
  const isOf = (flaw: Finding) => now.item !== null && flaw.seq === now.item, flaws = [...checked.flaws.filter(isOf), ...checked.flaws.filter(flaw => !isOf(flaw))]; // the chosen item's first
  const shown = flaws.slice(0, MOST), rest = flaws.slice(MOST), line = (flaw: Finding) => <Line key={flaw.message} flaw={flaw} chosen={isOf(flaw)} />;
  return (
    <>
      <p class={errors.length ? "bad" : isUnsure ? "amber" : "good"}><b aria-hidden="true">{errors.length ? "✕" : isUnsure ? "!" : "✓"}</b> {
        errors.length ? `Not to be flown: ${count(errors.length, "error")}${warnings ? `, ${count(warnings, "warning")}` : ""}.`
          : warnings ? `No error; ${count(warnings, "warning")} to read before it flies.` : "The check finds nothing wrong."} {kept(now, plan)}</p>
      <ul class="refusal">{shown.map(line)}</ul>
      {rest.length > 0 && <details><summary class="small">{count(rest.length, "more finding")}</summary><ul class="refusal">{rest.map(line)}</ul></details>}
      {checked.timeless && <p class="note">No time: {checked.timeless}.</p>}
    </>
  );
}

function kept(now: Studio, plan: Plan | null): string {
  if (!now.mission?.scenario) return "What stands there is not known: no clearance is looked at.";
  if (!plan || plan.kept === null || plan.kept === undefined) return "";
  if (plan.kept < 0) return `It may run ${meters(-plan.kept, 2)} into ${plan.nearest}.`;
  const words = `${meters(plan.kept, 2)} from ${plan.nearest}; ${meters(plan.required, 2)} required`;
  return plan.confidence === null ? `Predicted ${words}.` : `${share(plan.confidence)} of flights keep ${words}.`;
}

function Line({ flaw, chosen }: { flaw: Finding; chosen: boolean }) {
  const sign = <b aria-hidden="true">{flaw.severity === "error" ? "✕" : "!"}</b>, words = `${flaw.message}${flaw.hint ? `; ${flaw.hint}` : ""}`;
  return <li class={`${flaw.severity === "error" ? "bad" : "amber"}${chosen ? " chosen" : ""}`}>{flaw.seq ? <button type="button" class="plain-button" onClick={() => chooseItem(flaw.seq!)}>{sign} {words}</button> : <>{sign} {words}</>}</li>;
}

const count = (number: number, what: string): string => `${number} ${what}${number === 1 ? "" : "s"}`;

/** Who flies it, and in whose world it is judged. */
export function World({ now }: { now: Studio }) {
  const mission = isMission(now) ? now.mission : null;
  if (!mission) return null;
  const say = (scenario: string | null, autopilot: string | null) => send({ kind: "set_scenario", scenario, autopilot });
  const name = (path: string) => path.split(/[\\/]/).at(-1);
  return (
    <section aria-label="The mission">
      <h2>{now.document?.name}: a mission file</h2>
      <label class="field"><span>Flown by</span>
        <select value={mission.autopilot} onChange={event => say(mission.scenario, event.currentTarget.value)}>
          {mission.autopilots.map(one => <option key={one} value={one}>{one}</option>)}</select></label>
      <label class="field"><span>In the world of</span>
        <select value={mission.scenario ?? ""} onChange={event => say(event.currentTarget.value || null, mission.autopilot)}>
          <option value="">no scenario</option>
          {mission.worlds.map(one => <option key={one} value={one}>{name(one)}</option>)}</select></label>
      <p class="note">Checked for {mission.firmware}. It is no scenario: nothing plans it anew, and it is judged as it stands.</p>
      {mission.lost.map(words => <p key={words} class="amber">! {words}</p>)}
    </section>
  );
}

/** A flight of a log, item by item beside the estimate. */
export function Replayed({ now }: { now: Studio }) {
  const replay = now.replay;
  if (!replay) return null;
  return (
    <details class="panel" open>
      <summary>Flown, by {replay.log}</summary>
      <p class="note">Estimated {seconds(replay.estimated_s)}, {replay.flown_s === null ? "not flown to its end" : `flown ${seconds(replay.flown_s!)}`}.</p>
      <div class="scroll" tabIndex={0} role="region" aria-label="Estimated and flown">
        <table>
          <thead><tr><th scope="col">item</th><th scope="col">estimated</th><th scope="col">flown</th><th scope="col">difference</th></tr></thead>
          <tbody>{replay.items.map(leg => (
            <tr key={leg.seq} class={leg.seq === now.item ? "chosen" : ""}><th scope="row"><button type="button" onClick={() => chooseItem(leg.seq)}>{leg.seq}</button></th>
              <td>{seconds(leg.estimated_s)}</td><td>{seconds(leg.flown_s)}</td><td>{(leg.estimated_s - leg.flown_s).toFixed(1)} s</td></tr>
          ))}</tbody>
        </table>
      </div>
      {replay.remarks.map(words => <p key={words} class="note">{words}</p>)}
    </details>
  );
}
