import { useComputed } from "@preact/signals";
import type { Studio } from "../../model/studio";

/** Sections, and numbers of measures; a click looks at a measure. */
export function Ruler({ studio }: { studio: Studio }) {
  const every = useComputed(() => {
    const pixels = studio.scale.value;
    return [1, 2, 4, 8, 16, 32, 64].find((count) => count * pixels >= 44) ?? 128;
  });
  const length = studio.length.value;
  const numbers = Array.from({ length: Math.ceil(length / every.value) }, (_, index) => index * every.value);
  return (
    <div class="ruler">
      <div class="name"><span>measures</span></div>
      <div
        class="lane"
        onPointerDown={(event) => {
          if ((event.target as HTMLElement).closest("button")) return;
          const left = (event.currentTarget as HTMLElement).getBoundingClientRect().left;
          studio.cursor.value = Math.max(0, Math.floor((event.clientX - left) / studio.scale.value));
        }}
      >
        {studio.spans.value.map((span) => (
          <button
            key={span.number}
            class="section"
            aria-pressed={studio.isSelected({ list: "section", number: span.number })}
            style={{ "--start": span.first, "--length": span.measures }}
            onClick={(event) => studio.select({ list: "section", number: span.number }, event.shiftKey)}
          >
            <span>{span.name}{span.wait || span.repeat === 0 ? " · waits" : span.repeat > 1 ? ` ×${span.repeat}` : ""}{span.then ? ` → ${span.then}` : ""}</span>
          </button>
        ))}
        {numbers.map((measure) => <i key={measure} style={{ "--start": measure }}>{measure + 1}</i>)}
      </div>
    </div>
  );
}
