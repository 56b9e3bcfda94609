import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { freeBefore, gapOf, type Gap } from "../../model/gap";
import type { Studio } from "../../model/studio";
import { WaysDialog } from "./ways_dialog";

/** Below the library: the ways into the selected formation, or the free measures before it, to choose from. */
export function GapBar({ studio }: { studio: Studio }) {
  const filling = useSignal(false);
  const gap = gapOf(studio.boxes.value, studio.selected.value);
  const free = gap && freeBefore(studio.boxes.value, gap);
  const chosen = filling.value ? free : gap;
  useEffect(() => {
    if (!gap) studio.choosing.value = false;
  }, [studio, gap === null]);
  useEffect(() => {
    if (!studio.choosing.value) filling.value = false;
  }, [studio.choosing.value]);
  if (!gap) return null;
  return (
    <>
      <div class="gapbar">
        <span>{gap.free ? inWords(gap) : `Ways into ${gap.formation}`}</span>
        {free && <button title={inWords(free)} onClick={() => { filling.value = true; studio.choosing.value = true; }}>Fill {Math.round(free.length)} before …</button>}
        <button class="primary" onClick={() => { studio.choosing.value = true; }} title="Compare the ways, and choose (W)">{gap.free ? "Fill …" : "Choose …"}</button>
      </div>
      {studio.choosing.value && chosen && <WaysDialog key={String(chosen.free)} studio={studio} gap={chosen} onClose={() => { studio.choosing.value = false; }} />}
    </>
  );
}

function inWords(gap: Gap): string {
  const measures = Math.round(gap.length);
  return `${measures} free ${measures === 1 ? "measure" : "measures"} between ${gap.after} and ${gap.formation}`;
}
