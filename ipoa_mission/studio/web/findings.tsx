// What binds the flight and where; plans that were kept, side by side; what to know.
import type { Plan } from "./messages";
import { asLastProved, keepCandidates, proved, set, surveyed, type Candidate, type Studio } from "./store";
import { meters, seconds, share } from "./words";

export function Bindings({ now }: { now: Studio }) {
  const plan = proved(now);
  if (!plan?.bindings.length) return null;
  return (
    <section aria-label="What binds where">
      <h2>What binds where</h2>
      <ul class="bindings">
        {plan.bindings.map(binding => (
          <li key={binding.words}>
            <button type="button" class={binding.what} onClick={() => set({ at: binding.at })}>
              <b>{binding.what === "near" ? "closest" : binding.what === "slow" ? "slow" : "danger"}</b> {binding.words}</button></li>
        ))}
      </ul>
    </section>
  );
}

const ROWS: [string, (plan: Plan) => string][] = [
  ["flight", plan => seconds(plan.total_s)],
  ["clearance", plan => (plan.kept === null ? "–" : `${plan.confidence === null ? "predicted" : `${share(plan.confidence)} keep`} ${meters(plan.kept, 2)}`)],
  ["nearest", plan => plan.nearest],
  ["path", plan => meters(plan.length, 0)],
  ["waypoints", plan => String(plan.waypoints ?? "–")],
  ["energy", plan => (plan.energy_wh === null ? "–" : `${plan.energy_wh.toFixed(1)} Wh`)],
  ["proof", plan => plan.proof],
];

/** The plan; of a survey all flights together, drawn one after the other. */
function whole(now: Studio): Plan | null {
  const survey = surveyed(now), plans = survey?.flights.map(one => one.plan) ?? [], first = plans[0];
  if (!survey || !first) return proved(now);
  const least = plans.reduce((one, other) => ((other.kept ?? Infinity) - other.required < (one.kept ?? Infinity) - one.required ? other : one));
  const line = { points: plans.flatMap(plan => plan.course.line.points), up: plans.flatMap(plan => plan.course.line.up) };
  return { ...least, course: { ...first.course, line }, total_s: survey.total_s, energy_wh: survey.energy_wh, length: plans.reduce((sum, plan) => sum + plan.length, 0), proof: plans.map(plan => plan.proof).join(" "), waypoints: null };
}

export function Candidates({ now, take }: { now: Studio; take: (candidate: Candidate) => void }) {
  const plan = whole(now);
  const shown: { name: string; plan: Plan; candidate?: Candidate }[] = now.candidates.map(candidate => ({ ...candidate, candidate }));
  if (plan) shown.push({ name: "now", plan });
  const keep = () => {
    const name = [..."ABCD"].find(letter => !now.candidates.some(one => one.name === letter)) ?? "E";
    keepCandidates([...now.candidates, { name, plan: plan!, text: now.document!.text }]);
  };
  if (!shown.length && !whole(asLastProved(now))) return null;
  return (
    <section class="candidates" aria-label="Candidates">
      <h2>Candidates <button type="button" disabled={!plan || now.candidates.length > 3} onClick={keep}>Keep this one</button></h2>
      {now.candidates.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label="Candidates side by side">
          <table>
            <thead><tr><td />{shown.map(one => <th scope="col" key={one.name}>{one.name}</th>)}</tr></thead>
            <tbody>{ROWS.map(([label, value]) => <tr key={label}><th scope="row">{label}</th>{shown.map(one => <td key={one.name}>{value(one.plan)}</td>)}</tr>)}
              <tr><th scope="row"><span class="hidden">do</span></th>{shown.map(one => <td key={one.name}>{one.candidate && <>
                <button type="button" onClick={() => take(one.candidate!)}>Take</button>
                <button type="button" aria-label={`forget ${one.name}`} onClick={() => keepCandidates(now.candidates.filter(other => other !== one.candidate))}>×</button></>}</td>)}</tr>
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

export function Remarks({ now }: { now: Studio }) {
  const plan = proved(now);
  if (!plan) return null;
  return (
    <details class="panel">
      <summary>Limits that were proved, and remarks</summary>
      <ul class="plain">{plan.limits.map(limit => <li key={limit.limit + limit.words} class={limit.is_kept ? "" : "bad"}>{limit.is_kept ? "✓" : "✕"} {limit.limit}: {limit.words}</li>)}</ul>
      {plan.warnings.length > 0 && <ul class="plain">{plan.warnings.map(warning => <li key={warning} class="amber">! {warning}</li>)}</ul>}
      {plan.remarks.length > 0 && <ul class="plain">{plan.remarks.map(remark => <li key={remark}>{remark}</li>)}</ul>}
      <p class="note">{[plan.proof && `Proof ${plan.proof}`, plan.confidence !== null && `${share(plan.confidence)} of flights`].filter(Boolean).join(", ")}</p>
    </details>
  );
}
