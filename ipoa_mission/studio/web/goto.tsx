// A place is looked for by its coordinates; nobody is asked but the program itself.
import { useState } from "preact/hooks";
import { send, set, type Studio } from "./store";

export function GoTo({ now }: { now: Studio }) {
  const [place, setPlace] = useState("");
  const go = (event: Event) => {
    event.preventDefault();
    set({ troubles: now.troubles.filter(one => one.of !== "edit") });
    send({ kind: "find", place });
  };
  return (
    <form class="goto" role="search" onSubmit={go}>
      <input type="text" value={place} required spellcheck={false} aria-label="Go to a place: degrees" placeholder="Go to degrees"
        onInput={event => setPlace(event.currentTarget.value)} />
      {now.found && <button type="button" aria-label="Forget the place" onClick={() => { set({ found: null }); setPlace(""); }}>✕</button>}
    </form>
  );
}
