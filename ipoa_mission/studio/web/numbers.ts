// Things of a list are meant by their numbers: what is done while numbers change waits until those that then count are
// shown, as when an item is put in and taken out at once.
import type { Edit } from "./messages";

type Op = Edit["changes"][number]["op"];
const RENUMBERS: ReadonlySet<Op> = new Set<Op>(["add", "take", "insert_item", "take_item", "plain_items"]);

/** The revision of what is shown, where a change from here has made its numbers old. */
let old: number | null = null;
let choseOld = false;
let waiting: (() => void)[] = [];

/** What is to be done by numbers waits, if they are to come; not if something was chosen by those that are shown. */
export function waits(action: () => void): boolean {
  if (old === null || choseOld) return false;
  waiting.push(action);
  return true;
}

/** What is to be done goes behind what waits, if anything does. */
export function waitsBehind(action: () => void): boolean {
  return waiting.length > 0 && waits(action);
}

/** A change was sent that was of what is shown. */
export function changed(seen: number, changes: Edit["changes"]): void {
  if (changes.some(change => RENUMBERS.has(change.op))) [old, choseOld] = [seen, false];
}

/** Something is chosen by the numbers that are shown. */
export function chosenAsShown(): void {
  choseOld = old !== null;
}

/** What is shown now; `refused`: there will be no other numbers. */
export function shows(revision: number | undefined, refused = false): void {
  if (old === null || (revision === old && !refused)) return;
  const actions = refused ? [] : waiting;
  [old, choseOld, waiting] = [null, false, []];
  for (const action of actions) action();
}
