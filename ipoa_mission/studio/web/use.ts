// A component that shows what the window knows, and shows it again when it changes.
import { useEffect, useState } from "preact/hooks";
import { listen, studio, type Studio } from "./store";

const waiting = new Set<(now: Studio) => void>();
let scheduled = false;

listen(() => {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    for (const show of waiting) show(studio);
  });
});

export function useStudio(): Studio {
  const [now, show] = useState(studio);
  useEffect(() => {
    waiting.add(show);
    show(studio);
    return () => { waiting.delete(show); };
  }, []);
  return now;
}
