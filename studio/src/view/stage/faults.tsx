import { meetingWords, tooFarWords } from "../../model/fault_words";
import type { StageState } from "../../model/stage_state";

const MOST = 6;
const NARROW = matchMedia("(max-width: 600px)");

/** What would go wrong in the measures that are looked at, in words. */
export function Faults({ stage }: { stage: StageState }) {
  const { meetings, tooFar, notes, refused } = stage.faults.value;
  const wrong = [...meetingWords(meetings), ...tooFarWords(tooFar)];
  const rows = [
    ...refused.map((one) => `${one.what}${one.remedy ? ` – ${one.remedy}` : ""}`),
    ...wrong,
    ...notes.filter((one) => one.measure !== null).map((one) => one.what),
  ];
  if (!rows.length) return null;
  const room = stage.tool.value === "select" && !NARROW.matches; // it would lie over what is drawn
  return (
    <details class="faults" open={room && wrong.length + refused.length > 0}>
      <summary>{refused.length ? "This would be refused" : summary(meetings.length, tooFar.length, rows.length)}</summary>
      <ul>
        {rows.slice(0, MOST).map((words, index) => <li key={index} class={index < refused.length + wrong.length ? "alarm" : ""}>{words}</li>)}
        {rows.length > MOST && <li>and {rows.length - MOST} more</li>}
      </ul>
    </details>
  );
}

function summary(meetings: number, far: number, all: number): string {
  const parts = [meetings ? `${meetings} ${meetings === 1 ? "pair" : "pairs"} would meet` : "", far ? `${far} too far` : ""].filter(Boolean);
  return parts.length ? parts.join(", ") : all === 1 ? "1 note" : `${all} notes`;
}
