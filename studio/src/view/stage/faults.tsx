import type { StageState } from "../../model/stage_state";

const MOST = 8;

/** What would go wrong in the measures that are looked at, in words. */
export function Faults({ stage }: { stage: StageState }) {
  const { meetings, tooFar, notes, refused } = stage.faults.value;
  const rows = [
    ...refused.map((one) => `Refused: ${one.what}${one.remedy ? ` – ${one.remedy}` : ""}`),
    ...meetings.map((one) => `Measure ${one.measure}: ${one.dancers[0]} and ${one.dancers[1]} would meet (${one.distance.toFixed(2)} m)`),
    ...tooFar.map((one) => `Measure ${one.measure}: too far for ${one.dancer}, ${one.distance.toFixed(1)} m; steps reach ${one.reach.toFixed(1)} m`),
    ...notes.filter((one) => one.measure !== null).map((one) => one.what),
  ];
  if (!rows.length) return null;
  return (
    <details class="faults" open={meetings.length + tooFar.length + refused.length > 0}>
      <summary>{summary(meetings.length, tooFar.length, rows.length)}</summary>
      <ul>
        {rows.slice(0, MOST).map((words, index) => <li key={index} class={index < refused.length + meetings.length + tooFar.length ? "alarm" : ""}>{words}</li>)}
        {rows.length > MOST && <li>and {rows.length - MOST} more</li>}
      </ul>
    </details>
  );
}

function summary(meetings: number, far: number, all: number): string {
  const parts = [meetings ? `${meetings} would meet` : "", far ? `${far} too far` : ""].filter(Boolean);
  return parts.length ? parts.join(", ") : all === 1 ? "1 note" : `${all} notes`;
}
