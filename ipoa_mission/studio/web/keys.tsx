// The keys of the page, told on it.
import { toolsOf } from "./bar";
import type { Studio } from "./store";

const KEYS: [string, string][] = [
  ["arrow keys", "with a tool: move a crosshair on the map by a meter, with Shift by ten; on a point or a corner: move that"],
  ["c", "the crosshair without a tool: Enter takes hold of what is there, and puts it down"],
  ["Enter", "place a corner or a point; twice on one place, or on the first corner, closes what is drawn"],
  ["Backspace", "take the last corner back"],
  ["Delete", "take out what is chosen"],
  ["Esc", "leave; put the tool away"],
  ["Home", "the whole flight on the map"],
  ["2, 3", "from above, in space"],
  ["Ctrl-Z, Ctrl-Y, Ctrl-S", "undo, redo, save"],
  ["?", "these keys"],
];

export function Keys({ now }: { now: Studio }) {
  const tools = toolsOf(now).map(([, , , words, key]): [string, string] => [key, words.toLowerCase()]);
  return (
    <details class="panel keys">
      <summary>Keys</summary>
      <table><tbody>{[...tools, ...KEYS].map(([key, words]) => <tr key={key}><th scope="row"><kbd>{key}</kbd></th><td>{words}</td></tr>)}</tbody></table>
    </details>
  );
}
