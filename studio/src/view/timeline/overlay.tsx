import type { Studio } from "../../model/studio";
import { LANE, type TimelineState } from "./state";

/** What is above the rows: what is held as it would be, the chosen measures, cursor and playhead. */
export function Overlay({ studio, state }: { studio: Studio; state: TimelineState }) {
  const tops = state.tops.value;
  const height = tops.at(-1) ?? 0;
  return (
    <div class="over" style={{ height: `${height}px` }} aria-hidden="true">
      <Ghosts state={state} />
      <Chosen studio={studio} />
      <Playhead studio={studio} />
      {studio.cursor.value !== null && <i class="playhead cursor" style={{ "--at": studio.cursor.value }} />}
    </div>
  );
}

function Chosen({ studio }: { studio: Studio }) {
  const range = studio.range.value;
  return range ? <i class="extent" style={{ "--start": range[0], "--length": range[1] - range[0] }} /> : null;
}

function Playhead({ studio }: { studio: Studio }) {
  const { value } = studio.playhead;
  return value === null ? null : <i class="playhead" style={{ "--at": value }} />;
}

function Ghosts({ state }: { state: TimelineState }) {
  const gesture = state.gesture.value;
  if (!gesture) return null;
  if (gesture.kind === "marquee") {
    const { x, y } = gesture;
    return <i class="marquee" style={{ left: `${x[0]}px`, top: `${y[0]}px`, width: `${x[1] - x[0]}px`, height: `${y[1] - y[0]}px` }} />;
  }
  const tops = state.tops.value;
  const caution = state.caution.value;
  const ghosts = state.ghosts.value.slice(0, 200);
  const first = ghosts[0];
  return (
    <>
      {ghosts.map((ghost, index) => (
        <i
          key={index}
          class={`ghost${caution?.refused ? " refused" : caution ? " doubtful" : ""}${ghost.length ? "" : " point"}`}
          style={{ "--start": ghost.start, "--length": ghost.length, top: `${(tops[ghost.row] ?? 0) + 3 + ghost.lane * LANE}px` }}
        >
          {ghost.label}
        </i>
      ))}
      {first && <b class={`ghost-words${caution?.refused ? " refused" : ""}`} style={{ "--start": first.start, top: `${(tops[first.row + 1] ?? 0) + 2}px` }}>{words(first, caution?.words)}</b>}
    </>
  );
}

function words(ghost: { start: number; length: number }, caution: string | undefined): string {
  const measure = Math.round((ghost.start + 1) * 100) / 100;
  const length = Math.round(ghost.length * 100) / 100;
  return `measure ${measure}${length ? `, ${length} long` : ""}${caution ? ` – ${caution}` : ""}`;
}
