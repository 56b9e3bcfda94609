import { useSignal } from "@preact/signals";
import { reached, type Reached } from "../../model/danced";
import type { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { Switch } from "./tool_bar";

const MEASURES_AT_CURSOR = 4;

/** Which moment the stage shows: what is danced now, a measure of the preview, or a range that is played. */
export function MomentBar({ studio, stage }: { studio: Studio; stage: StageState }) {
  const cursor = studio.cursor.value;
  const played = stage.played.value;
  const progress = studio.preview.progress.value;
  const isPreview = cursor !== null || played !== null;
  return (
    <div class={`strip moment${isPreview ? " preview" : ""}`}>
      <strong class="which" role="status">
        {played
          ? `Measures ${played.from}–${played.to}, preview`
          : cursor === null
            ? "Now"
            : `Measure ${Math.floor(cursor) + 1}, preview`}
      </strong>
      {(played ? played.led : stage.led.value) && <span class="hint">if somebody leads there</span>}
      {played && <span class="hint counter">{stage.playedMeasure.value.toFixed(1)}</span>}
      {isPreview && stage.waits.value && <span class="hint">{progress === null ? "working …" : `simulated up to measure ${progress}`}</span>}
      {isPreview && <button onClick={() => stage.now()}>Back to now</button>}
      {studio.dancers.value.length > 0 && <span class="hint">{studio.dancers.value.length} selected</span>}
      <PlayRange studio={studio} stage={stage} />
      <button
        aria-pressed={stage.trying.value}
        title="Keep changes of the stage in the preview; send them together"
        onClick={() => (stage.trying.value && !stage.tried.value.length ? stage.discard() : (stage.trying.value = true))}
      >
        Try
      </button>
      {stage.tried.value.length > 0 && (
        <span class="choice" role="group" aria-label="Changes that are tried">
          <Switch value={stage.without} words="Without" />
          <button class="primary" onClick={() => void stage.sendTried()}>Send {stage.tried.value.length}</button>
          <button onClick={() => stage.discard()}>Discard</button>
        </span>
      )}
    </div>
  );
}

/** Plays measures from … to … of the preview. Left empty: those chosen in the timeline, of the selected box, or four at the cursor. */
function PlayRange({ studio, stage }: { studio: Studio; stage: StageState }) {
  const from = useSignal("");
  const to = useSignal("");
  const { from: first, to: last, led } = wanted(studio, stage);
  const begin = Number(from.value) || first;
  const end = Math.max(begin, Number(to.value) || Math.max(last, begin));
  return (
    <form
      class="range"
      onSubmit={(event) => {
        event.preventDefault();
        if (stage.played.value) stage.stop();
        else void stage.play({ from: begin, to: end, led });
      }}
    >
      <input type="number" min={1} aria-label="First measure" placeholder={String(first)} value={from.value} onInput={(event) => { from.value = event.currentTarget.value; }} />
      <span aria-hidden="true">–</span>
      <input type="number" min={1} aria-label="Last measure" placeholder={String(Math.max(last, begin))} value={to.value} onInput={(event) => { to.value = event.currentTarget.value; }} />
      <button>{stage.played.value ? "Stop" : "Play"}</button>
    </form>
  );
}

function wanted(studio: Studio, stage: StageState): Reached {
  const range = studio.range.value;
  if (range) return reached(studio.score.value, Math.floor(range[0]), Math.ceil(range[1]) - Math.floor(range[0]));
  const spans = studio.selected.value.flatMap((one) => {
    const found = ["segment", "element", "sequence", "improvise"].includes(one.list) ? stage.measuresOf(one.list, one.number) : null;
    return found ? [found] : [];
  });
  const [one] = spans;
  if (one) {
    const alike = spans.filter((each) => each.led === one.led); // the two kinds are counted differently
    return { from: Math.min(...alike.map((each) => each.from)), to: Math.max(...alike.map((each) => each.to)), led: one.led };
  }
  return reached(studio.score.value, studio.cursor.value ?? Math.max(0, Math.floor(studio.playhead.value ?? 0)), MEASURES_AT_CURSOR);
}
