// The items of a mission, as they are numbered on the vehicle: what each does, where, when it is done; of a mission file
// that is open also what it is made of, to be changed.
import { NumberInput } from "./form";
import type { ItemField, MissionItem } from "./messages";
import { chooseItem, edit, isMission, proved, set, studio, type Change, type Studio } from "./store";
import { seconds } from "./words";

const MISSION_FRAME = 2, ENDINGS = [20, 21, 85];
const FRAMES: [number, string][] = [[3, "m above home"], [0, "m AMSL"], [10, "m above ground"]];
const plain = (frame: number) => ({ 5: 0, 6: 3, 11: 10 } as Record<number, number>)[frame] ?? frame;

export function Items({ now }: { now: Studio }) {
  const plan = proved(now), open = isMission(now) ? now.mission : null;
  if (!plan && !open) return null;
  const stops = new Map(plan?.stops.map(stop => [stop.seq, stop]));
  const rows = open
    ? open.items.map(item => ({ seq: item.seq, words: item.words, up: stops.get(item.seq)?.up ?? item.up, ground: stops.get(item.seq)?.above_ground ?? null, done: stops.get(item.seq)?.done_s }))
    : plan!.stops.map(stop => ({ seq: stop.seq, words: stop.words, up: stop.up, ground: stop.above_ground, done: stop.done_s }));
  const wrong = new Map(now.checked?.flaws.map(flaw => [flaw.seq, flaw.severity] as const).reverse());
  return (
    <details class="panel items" open>
      <summary>Items{open ? ` (${open.items.length})` : ""}</summary>
      <div class="scroll" tabIndex={0} role="region" aria-label="Items">
        <table>
          <thead><tr><th scope="col">item</th><th scope="col">above home</th><th scope="col">above ground</th><th scope="col">done at</th></tr></thead>
          <tbody>
            {rows.map((row, n) => (
              <tr key={n} class={row.seq === now.item ? "chosen" : ""}>
                <th scope="row"><button type="button" aria-pressed={row.seq === now.item} onClick={() => chooseItem(row.seq)}>
                  {open && wrong.get(row.seq) && <b class={wrong.get(row.seq) === "error" ? "bad" : "amber"} title={wrong.get(row.seq)}>! </b>}{row.seq} {row.words}</button></th>
                <td>{meters(row.up)}</td><td>{meters(row.ground)}</td>
                <td>{row.done === undefined ? "" : seconds(row.done)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}

const meters = (value: number | null | undefined): string => (value === null || value === undefined ? "" : `${value.toFixed(1)} m`);

/** The item that is chosen, as it can be changed. */
export function ChosenItem({ now }: { now: Studio }) {
  const mission = isMission(now) ? now.mission : null;
  if (!mission) return null;
  const item = mission.items.find(one => one.seq === now.item);
  if (!item) {
    return (
      <section aria-label="Chosen item"><h2>No item is chosen</h2>
        <p class="note">Choose one in the list or on the map, to change, move or remove it; <i>waypoint</i> above the map puts one in.</p>
        <Add seq={placeForNew(now)} words="Add before the end" now={now} /></section>
    );
  }
  const kind = mission.kinds.find(one => one.command === item.command);
  const put = (what: Put["what"], value: number | null, words: string) => edit(`item ${item.seq}: ${words}`, { op: "put_item", seq: item.seq, what, value });
  return (
    <section aria-label="Chosen item">
      <h2>Item {item.seq}: {item.words}</h2>
      {item.part_of ? (
        <><p class="note">It is one of a survey or scan that QGroundControl edits as a whole (items {item.part_of[0]} to {item.part_of[1]}).</p>
          <p class="column"><button type="button" onClick={() => edit("plain items", { op: "plain_items", seq: item.seq })}>Make plain items of it, to change them here</button></p></>
      ) : (
        <>
          <label class="field"><span>Command</span>
            <select value={item.command} onChange={event => put("command", Number(event.currentTarget.value), "command")}>
              <Commands now={now} />
              {!kind && <option value={item.command}>{`command ${item.command}`}</option>}
            </select></label>
          {item.frame !== MISSION_FRAME && <Height item={item} put={put} />}
          {shown(item, kind?.fields ?? []).map(field => (
            <NumberInput key={`${item.seq} ${field.what}`} label={field.label} unit={field.unit} about={field.about} value={valueOf(item, field.what)} step="any"
              change={value => put(field.what, value, field.label.toLowerCase())} />
          ))}
          {item.frame !== MISSION_FRAME && (
            <details><summary class="small">Coordinates</summary>
              <NumberInput label="Latitude" unit="°" value={valueOf(item, "param5")} step={0.00001} change={value => value !== null && put("param5", value, "latitude")} />
              <NumberInput label="Longitude" unit="°" value={valueOf(item, "param6")} step={0.00001} change={value => value !== null && put("param6", value, "longitude")} />
            </details>
          )}
          <Add seq={item.seq + 1} words="Add after it" now={now} />
          <p class="buttons"><button type="button" onClick={() => takeItem(item.seq)}>Remove item {item.seq}</button></p>
        </>
      )}
    </section>
  );
}

type Put = Extract<Change, { op: "put_item" }>;

function Height({ item, put }: { item: MissionItem; put: (what: Put["what"], value: number | null, words: string) => void }) {
  return (
    <div class="field height">
      <label><span>Height</span></label>
      <NumberInput bare label="Height" value={item.values[6] ?? null} step={1} change={value => value !== null && put("param7", value, `height ${value} m`)} />
      <select aria-label="Height counts from" value={plain(item.frame)} onChange={event => put("frame", Number(event.currentTarget.value), "height counts from elsewhere")}>
        {FRAMES.map(([frame, words]) => <option key={frame} value={frame}>{words}</option>)}
        {!FRAMES.some(([frame]) => frame === plain(item.frame)) && <option value={plain(item.frame)}>frame {item.frame}</option>}
      </select>
    </div>
  );
}

/** The fields of a command, and every other param that the file has set. */
function shown(item: MissionItem, fields: ItemField[]): ItemField[] {
  const known = new Set(fields.map(field => field.what));
  const set = [1, 2, 3, 4].map(n => `param${n}` as ItemField["what"]).filter(what => !known.has(what) && valueOf(item, what));
  return [...fields, ...set.map(what => ({ what, label: what, unit: "", about: "" }))];
}

const valueOf = (item: MissionItem, what: string): number | null => item.values[Number(what.slice(5)) - 1] ?? null;

/** Groups of commands by their MAV_CMD numbers; what is in none is for other vehicles, or rare. */
const GROUPS: [string, (command: number) => boolean][] = [
  ["Flight", command => [16, 17, 18, 19, 20, 21, 22, 31, 36, 82, 93, 178].includes(command)],
  ["Conditions and jumps", command => (command >= 112 && command <= 115) || [177, 600, 601].includes(command)],
  ["Camera and gimbal", command => (command >= 195 && command <= 206) || (command >= 530 && command <= 534) || (command >= 1000 && command <= 1001) || (command >= 2000 && command <= 2505)],
];
const OTHERS = "Rare, or of other vehicles";

/** The commands to choose from, by group; one that is shown stays among them. */
function Commands({ now }: { now: Studio }) {
  const kinds = now.mission?.kinds ?? [], groupOf = (command: number) => GROUPS.find(([, has]) => has(command))?.[0] ?? OTHERS;
  return <>{[...GROUPS.map(([name]) => name), OTHERS].map(group => (
    <optgroup key={group} label={group}>{kinds.filter(kind => groupOf(kind.command) === group).map(one => <option key={one.command} value={one.command}>{one.name}</option>)}</optgroup>
  ))}</>;
}

function Add({ seq, words, now }: { seq: number; words: string; now: Studio }) {
  return (
    <label class="field"><span>{words}</span>
      <select value="" onChange={event => { addItem(seq, Number(event.currentTarget.value), null); event.currentTarget.value = ""; }}>
        <option value="">choose …</option>
        <Commands now={now} />
      </select></label>
  );
}

/** Behind the item that is chosen, else before the mission's end. */
export function placeForNew(now: Studio): number {
  const items = now.mission?.items ?? [], last = items.at(-1);
  if (now.item !== null) return now.item + 1;
  return last && ENDINGS.includes(last.command) ? last.seq : items.length + 1;
}

export function addItem(seq: number, command: number, place: [number, number] | null): void {
  edit(`item ${seq} added`, { op: "insert_item", seq, command, place });
  set({ item: seq });
}

export function takeItem(seq: number): void {
  edit(`item ${seq} removed`, { op: "take_item", seq });
  set({ item: Math.max(1, Math.min(seq, (studio.mission?.items.length ?? 1) - 1)) });
}
