import { useEffect } from "preact/hooks";
import { gapOf } from "../../model/gap";
import type { Studio } from "../../model/studio";
import { WaysDialog } from "./ways_dialog";

/** Below the library: the ways of the selected formation, or the free measures between two, to choose from. */
export function GapBar({ studio }: { studio: Studio }) {
  const gap = gapOf(studio.boxes.value, studio.selected.value);
  useEffect(() => {
    if (!gap) studio.choosing.value = false;
  }, [studio, gap === null]);
  if (!gap) return null;
  return (
    <>
      <div class="gapbar">
        <span>{gap.free ? `${Math.round(gap.length)} free measures between ${gap.after} and ${gap.formation}` : `Ways into ${gap.formation}`}</span>
        <button class="primary" onClick={() => { studio.choosing.value = true; }} title="Compare the ways, and choose (W)">{gap.free ? "Fill …" : "Choose …"}</button>
      </div>
      {studio.choosing.value && <WaysDialog studio={studio} gap={gap} onClose={() => { studio.choosing.value = false; }} />}
    </>
  );
}
