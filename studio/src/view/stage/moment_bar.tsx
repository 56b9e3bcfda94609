import { useSignal } from "@preact/signals";
import { dancedMeasure } from "../../model/danced";
import type { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { Switch } from "./tool_bar";

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
            : stage.looked.value === null
              ? `Measure ${Math.floor(cursor) + 1} comes only if somebody leads there`
              : `Measure ${Math.floor(cursor) + 1}, preview`}
      </strong>
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
  const [first, last] = wanted(studio, stage);
  const begin = Number(from.value) || first;
  const end = Math.max(begin, Number(to.value) || Math.max(last, begin));
  return (
    <form
      class="range"
      onSubmit={(event) => {
        event.preventDefault();
        if (stage.played.value) stage.stop();
        else void stage.play(begin, end);
      }}
    >
      <input type="number" min={1} aria-label="First measure" placeholder={String(first)} value={from.value} onInput={(event) => { from.value = event.currentTarget.value; }} />
      <span aria-hidden="true">–</span>
      <input type="number" min={1} aria-label="Last measure" placeholder={String(Math.max(last, begin))} value={to.value} onInput={(event) => { to.value = event.currentTarget.value; }} />
      <button>{stage.played.value ? "Stop" : "Play"}</button>
    </form>
  );
}

function wanted(studio: Studio, stage: StageState): [number, number] {
  const range = studio.range.value;
  const begin = range && dancedMeasure(studio.score.value, Math.floor(range[0]));
  if (range && begin) return [begin, begin + Math.ceil(range[1]) - Math.floor(range[0]) - 1];
  const spans = studio.selected.value.flatMap((one) => {
    const found = ["segment", "element", "sequence", "improvise"].includes(one.list) ? stage.measuresOf(one.list, one.number) : null;
    return found ? [found] : [];
  });
  if (spans.length) return [Math.min(...spans.map((one) => one[0])), Math.max(...spans.map((one) => one[1]))];
  const here = dancedMeasure(studio.score.value, studio.cursor.value ?? Math.max(0, Math.floor(studio.playhead.value ?? 0))) ?? 1;
  return [here, here + 3];
}
