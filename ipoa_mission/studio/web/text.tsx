// The scenario's own text, for who prefers to write; and what to do when another program has written it.
import { useState } from "preact/hooks";
import { send, type Studio } from "./store";

export function Text({ now }: { now: Studio }) {
  const [draft, setDraft] = useState<{ text: string; seen: number } | null>(null);
  const shown = now.document;
  if (!shown) return null;
  return (
    <details class="panel">
      <summary>{shown.of === "mission" ? "The file's text" : "The scenario's text"}</summary>
      <textarea aria-label="The scenario's text" spellcheck={false} rows={16} value={draft?.text ?? shown.text}
        onInput={event => setDraft({ text: event.currentTarget.value, seen: draft?.seen ?? shown.revision })} />
      <p class="buttons">
        <button type="button" disabled={!draft} onClick={() => setDraft(null)}>As it was</button>
        <button type="button" class="strong" disabled={!draft} onClick={() => { send({ kind: "rewrite", ...draft! }); setDraft(null); }}>Apply</button></p>
      <p class="note">{shown.path}</p>
    </details>
  );
}

export function Outside({ now }: { now: Studio }) {
  if (!now.document?.changed_outside) return null;
  return (
    <section class="bad" role="alert">
      <p>Another program has changed {now.document.name}.toml, and there are unsaved changes here. Either can be undone.</p>
      <p class="buttons"><button type="button" onClick={() => send({ kind: "do", what: "take_theirs" })}>Take its text</button>
        <button type="button" onClick={() => send({ kind: "do", what: "save_over" })}>Save over it</button></p>
    </section>
  );
}
