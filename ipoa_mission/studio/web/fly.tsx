// Flying: first the mission goes on a vehicle; then, deliberately, it is armed and started, by name.
import { useEffect, useRef, useState } from "preact/hooks";
import type { OrderThen, ReserveNow } from "./messages";
import { isMission, proved, send, type Studio } from "./store";
import { asksBattery, NextFlight } from "./survey";
import { seconds, share } from "./words";

const ORDERS: Record<OrderThen["what"], string> = { hold: "Hold", go_on: "Go on", rtl: "Return now", land: "Land now" };

const LANDED = { rtl: "Returned and landed, as ordered", land: "Landed, as ordered" };

export function Fly({ now }: { now: Studio }) {
  const ready = isMission(now) ? isSound(now) : proved(now) !== null;
  const [real, setReal] = useState(false);
  const [link, setLink] = useState("udpin:127.0.0.1:14550");
  const [system, setSystem] = useState<number | null>(null);
  const [listening, setListening] = useState(false);
  useEffect(() => setListening(false), [now.heard, now.troubles]);
  const [speedup, setSpeedup] = useState(5);
  const [sets, setSets] = useState(false);
  const [charged, setCharged] = useState(false);
  const phase = now.flight?.phase ?? "idle";
  const [open, setOpen] = useState(false);
  useEffect(() => { if (phase !== "idle") setOpen(true); }, [phase]);
  const lost = now.flight?.lost_s ?? null;
  const idle = phase === "idle" || phase === "over";
  return (
    <details class="panel" open={open} onToggle={event => setOpen(event.currentTarget.open)}>
      <summary>Fly it</summary>
      {idle && (
        <div class="fly">
          <fieldset>
            <legend class="hidden">On what</legend>
            <label><input type="radio" name="on" checked={!real} onChange={() => setReal(false)} /> the built-in autopilot</label>
            <label><input type="radio" name="on" checked={real} onChange={() => setReal(true)} /> a vehicle, or SITL</label>
          </fieldset>
          {real
            ? <><label class="field wide"><span>Link</span><input type="text" value={link} spellcheck={false} onInput={event => { setLink(event.currentTarget.value); setSystem(null); }} /></label>
              <p class="buttons"><button type="button" disabled={listening} onClick={() => { setListening(true); send({ kind: "listen", link }); }}>{listening ? "listening …" : "Who is there?"}</button></p>
              {now.heard && <ul class="plain">{now.heard.links.map(row => (
                <li key={row.link + row.system}>{row.system === null ? <>{row.link}: {row.words}</>
                  : <button type="button" onClick={() => { setLink(row.link); setSystem(row.system); }}>{row.link}: <b>{row.words}</b></button>}</li>))}</ul>}
              <label class="check"><input type="checkbox" checked={sets} onChange={event => setSets(event.currentTarget.checked)} /> give it the parameters that this was made for, where it has others</label></>
            : <label class="field"><span>Speed-up</span><input type="number" min="0.5" max="1000" value={speedup} onChange={event => setSpeedup(Number(event.currentTarget.value) || 1)} /><em>×</em></label>}
          <NextFlight now={now} onLink={real} charged={charged} say={setCharged} />
          <button type="button" class="strong" disabled={!ready || (real && !charged && asksBattery(now))}
            onClick={() => { send({ kind: "upload", link: real ? link : null, system: real ? system : null, speedup, set_params: real && sets, flight: now.part, charged }); setCharged(false); }}>Upload</button>
          {!ready && <p class="note">{isMission(now) ? "Only a mission in which the check finds no error is uploaded." : "Only a proved path is uploaded."}</p>}
        </div>
      )}
      {now.flight && <p class={lost === null ? "note" : "bad"} role="status">{now.flight.words}</p>}
      {lost !== null && <p class="bad" aria-hidden="true">Link lost for {lost} s: nothing can be ordered, and what is shown is what it said last.</p>}
      {phase === "loaded" && now.loaded && <Confirm now={now} />}
      {!idle && phase !== "loaded" && <Watched now={now} />}
      {now.landed && phase === "over" && (
        <p class={now.landed.completed || now.landed.ordered ? "good" : "bad"}>{now.landed.completed ? "✓ Landed" : now.landed.ordered ? `✓ ${LANDED[now.landed.ordered]}` : `✕ ${now.landed.why_not}`}: flown {seconds(now.landed.flown_s)}, estimated {seconds(now.landed.estimated_s)}. Every frame is in {now.landed.log}.</p>
      )}
      {!idle && <button type="button" onClick={() => send({ kind: "do", what: "abandon" })}>{phase === "flying" ? "Stop watching" : "Leave it"}</button>}
    </details>
  );
}

/** Whether the check of an open mission as it is now found no error, and it has a flight. */
function isSound({ checked, document }: Studio): boolean {
  return checked !== null && checked.revision === document?.revision && checked.timeless === null && !checked.flaws.some(flaw => flaw.severity === "error");
}

/** Who starts a vehicle writes the mission's name, having read what will fly. */
function Confirm({ now }: { now: Studio }) {
  const loaded = now.loaded!;
  const [open, setOpen] = useState(false);
  const [typed, setTyped] = useState("");
  const dialog = useRef<HTMLDialogElement>(null);
  const stale = loaded.revision !== now.document?.revision;
  useEffect(() => { if (open) dialog.current?.showModal(); }, [open]);
  const close = () => { dialog.current?.close(); setOpen(false); setTyped(""); };
  const start = () => {
    send({ kind: "start", vehicle: loaded.vehicle, mission: loaded.mission, proof: loaded.proof });
    close();
  };
  return (
    <>
      {loaded.remarks.length > 0 && <ul class="plain">{loaded.remarks.map(remark => <li key={remark}>{remark}</li>)}</ul>}
      {stale && <p class="bad">It was changed after the upload: upload again.</p>}
      <button type="button" class="danger" disabled={stale} onClick={() => setOpen(true)}>Arm and start …</button>
      {open && (
        <dialog ref={dialog} aria-labelledby="start-title" onCancel={close}>
          <h2 id="start-title">{loaded.built_in ? "Start a flight on the built-in autopilot?" : "Arm and start a real vehicle?"}</h2>
          <dl>
            <dt>vehicle</dt><dd>{loaded.vehicle}</dd>
            <dt>mission</dt><dd>{loaded.mission}, {loaded.items} items</dd>
            <dt>{isMission(now) ? "check" : "proof"}</dt><dd><code>{loaded.proof}</code></dd>
          </dl>
          {!loaded.built_in && <p class="bad">Its motors will turn. Nobody may stand near it.</p>}
          <form onSubmit={event => { event.preventDefault(); if (typed === loaded.mission) start(); }}>
            <label class="field wide"><span>To start it, write <b>{loaded.mission}</b></span>
              <input type="text" value={typed} autocomplete="off" spellcheck={false} onInput={event => setTyped(event.currentTarget.value)} /></label>
            <p class="buttons"><button type="button" onClick={close}>Do not start</button>
              <button type="submit" class="danger" disabled={typed !== loaded.mission}>Arm and start</button></p>
          </form>
        </dialog>
      )}
    </>
  );
}

const isShort = (reserve: ReserveNow | null): boolean => reserve !== null && reserve.lands[1] < reserve.reserve;

function Watched({ now }: { now: Studio }) {
  const seen = now.seen;
  if (!seen) return null;
  const reserve = seen.reserve ?? null;
  const late = seen.flown_s !== null && seen.expected_s !== null ? seen.flown_s - seen.expected_s : null;
  return (
    <>
    <dl class="figures">
      <div><dt>flying for</dt><dd>{seconds(seen.time_s)}<small>{seen.held ? "it holds its position" : late === null ? "" : `${Math.abs(late).toFixed(1)} s ${late < 0 ? "ahead of" : "behind"} the estimate`}</small></dd></div>
      <div><dt>items done</dt><dd>{seen.done}<small>of {now.loaded?.items ?? "?"}</small></dd></div>
      <div><dt>height</dt><dd>{seen.up.toFixed(1)} m<small>{seen.speed.toFixed(1)} m/s</small></dd></div>
      {seen.battery_left != null && <div class={isShort(reserve) ? "bad" : ""}><dt>battery</dt><dd>{share(seen.battery_left)}{reserve && <small>{share(reserve.planned)} planned</small>}</dd></div>}
      {seen.satellites != null && <div><dt>satellites</dt><dd>{seen.satellites}</dd></div>}
      {seen.wind && <div><dt>wind</dt><dd>{seen.wind[0].toFixed(1)} m/s<small>from {seen.wind[1]}°</small></dd></div>}
    </dl>
    {reserve && <p class={isShort(reserve) ? "bad" : "note"}>It lands with {share(reserve.lands[1])} ({share(reserve.lands[0])} to {share(reserve.lands[2])}) of its battery; {share(reserve.reserve)} {isShort(reserve) ? "are required: not enough" : "required"}.</p>}
    {(seen.deviations ?? []).length > 0 && <ul class="plain bad" role="alert" aria-label="Deviations from the forecast">{seen.deviations!.map(words => <li key={words}>{words}</li>)}</ul>}
    <ul class="plain orders" aria-label="What can be ordered now">{(seen.orders ?? []).map(one => (
      <li key={one.what} class={one.clear === null ? "" : one.clear ? "good" : "bad"}>
        <button type="button" disabled={now.flight?.lost_s != null} onClick={() => send({ kind: "order", what: one.what })}>{ORDERS[one.what]}</button>
        {" "}{one.words}{one.seconds === null ? "" : `, ${seconds(one.seconds)}`}
      </li>
    ))}</ul>
    {(seen.said ?? []).length > 0 && <details><summary class="small">It says: {seen.said![0]}</summary>
      <ul class="plain">{seen.said!.slice(1).map((words, n) => <li key={n}>{words}</li>)}</ul></details>}
    </>
  );
}
