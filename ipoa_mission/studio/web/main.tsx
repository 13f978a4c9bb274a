// The page: a map, what is known about the flight beside it, its profile below.
import "./trusted";
import "maplibre-gl/dist/maplibre-gl.css";
import "../../report/assets/palette.css";
import "../../report/assets/ways.css";
import "./studio.css";
import { render } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { Bar, listenToKeys } from "./bar";
import { Bindings, Candidates, Remarks } from "./findings";
import { Drop, Question } from "./drop";
import { Fly } from "./fly";
import { Chosen, Limits } from "./form";
import { GoTo } from "./goto";
import { useHands } from "./hands";
import { ChosenItem, Items } from "./items";
import { Keys } from "./keys";
import { makeMap } from "./map";
import { Replayed, World } from "./mission";
import { fitOnPaper } from "./paper";
import { showPointer } from "./pointer";
import { Profile } from "./profile";
import { showSpots } from "./spots";
import { StartPage } from "./start";
import { SeesLeast, SurveyFlights, SurveyForm } from "./survey";
import { useSurveyHands } from "./survey-hands";
import { asLastProved, isDragged, isMission, send, set, studio, type Candidate, type Studio } from "./store";
import { Outside, Text } from "./text";
import { useStudio } from "./use";
import { Verdict } from "./verdict";

function MapView({ now }: { now: Studio }) {
  const { notice, spoken, tiles, picture, world, whole } = now;
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    try {
      const map = makeMap(place.current!);
      showSpots(map);
      useHands(map);
      useSurveyHands(map);
      showPointer(map);
      fitOnPaper(map);
      Object.assign(window, { map }); // for tests, and for the curious
    } catch {
      set({ notice: "No map is drawn: this browser has no WebGL 2. All else works." });
    }
  }, []);
  return (
    <div class={`map${world ? "" : " unknown"}${whole ? " whole" : ""}`} role="region" aria-label="Map and tools">
      <div class="canvas" ref={place} />
      {tiles && picture && <p class="attribution">{tiles.attribution}</p>}
      <button type="button" class="enlarge" aria-pressed={whole} onClick={() => set({ whole: !whole })}>{whole ? "✕ close" : "⤢ whole screen"}</button>
      <GoTo now={now} />
      {notice && <p class="notice" role="status">{notice}</p>}
      <p class="spoken" aria-live="polite">{spoken}</p>
    </div>
  );
}

/** A candidate is taken by its whole scenario; undo leads back. */
function take(candidate: Candidate): void {
  if (studio.document) send({ kind: "rewrite", seen: studio.document.revision, text: candidate.text });
}

function Page() {
  const now = useStudio();
  if (now.start) return <><Bar /><StartPage now={now} /></>;
  const isScenario = !isMission(now), last = asLastProved(now), isPast = last !== now || isDragged(now);
  return (
    <>
      <Bar />
      <main>
        <div class="stage">
          <MapView now={now} />
          <Profile now={now} />
        </div>
        <aside class="side" aria-label="The flight">
          <Outside now={now} />
          <Question now={now} />
          <Verdict now={now} />
          <Replayed now={now} />
          {isScenario ? <><SurveyFlights now={now} /><Chosen now={now} /><Fly now={now} /><SurveyForm now={now} /><SeesLeast now={now} /></> : <><ChosenItem now={now} /><Items now={now} /><World now={now} /><Fly now={now} /></>}
          <div class={isPast ? "past" : ""} inert={isPast}><Bindings now={last} />{isScenario && <Items now={last} />}</div>
          {isScenario && <Candidates now={now} take={take} />}
          {isScenario && <><Limits now={now} /><Drop /></>}
          <Remarks now={now} />
          <Keys now={now} />
          <Text now={now} />
        </aside>
      </main>
    </>
  );
}

listenToKeys();
render(<Page />, document.getElementById("app")!);
