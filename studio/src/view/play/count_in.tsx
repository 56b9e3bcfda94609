import { useEffect, useRef } from "preact/hooks";
import { beatNow } from "../../model/figure";
import { launchInWords, nextOf } from "../../model/pads";
import type { Studio } from "../../model/studio";
import { onFrames } from "../../ui/animation";

/** More beats than this are told in measures. */
const MOST_BEATS = 8;

/** The beats until the next pad begins, large, on the beat. */
export function CountIn({ studio }: { studio: Studio }) {
  const number = useRef<HTMLElement>(null);
  const next = nextOf(studio.doc.launches.value);
  const { beats } = studio.doc.launches.value;
  const due = next?.due ?? null;
  useEffect(() => {
    if (due === null) return undefined;
    let last = Infinity;
    return onFrames((now) => {
      const element = number.current;
      if (!element) return;
      const danced = beatNow(studio.doc.clock.peek(), studio.library.heard, now, beats);
      const left = (last = Math.min(last, Math.max(1, Math.ceil(due - danced - 1e-3)))); // a late clock counts nothing twice
      const words = left > MOST_BEATS ? String(Math.ceil(left / beats)) : String(left);
      if (element.textContent !== words) {
        element.textContent = words;
        element.parentElement?.classList.toggle("measures", left > MOST_BEATS);
        element.parentElement?.classList.toggle("last", left === 1);
      }
      element.style.setProperty("--phase", String(danced - Math.floor(danced)));
    });
  }, [studio, due, beats]);
  if (!next || due === null) return null;
  return (
    <div class="countin" role="timer" aria-label={`Begins next: ${launchInWords(next)}`}>
      <b ref={number} />
      <span>
        <em /> {launchInWords(next)}
      </span>
    </div>
  );
}
