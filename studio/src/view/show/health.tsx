import { useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";

/** A late picture is told for so long [ms]. */
const TOLD_MS = 15_000;

/** How the machine is doing, in words. */
export function Health({ studio }: { studio: Studio }) {
  const late = useRef({ count: -1, more: 0, until: 0 });
  const count = studio.doc.clock.value?.late_frames ?? 0;
  const now = performance.now();
  if (late.current.count >= 0 && count > late.current.count) {
    late.current.more = (now < late.current.until ? late.current.more : 0) + count - late.current.count;
    late.current.until = now + TOLD_MS;
  }
  late.current.count = count;
  const troubles = troublesOf(studio, now < late.current.until ? late.current.more : 0);
  return (
    <p class={`health${troubles.length ? " trouble" : ""}`} role="status">
      {troubles.length ? troubles.join(" · ") : "All is well"}
    </p>
  );
}

function troublesOf(studio: Studio, late: number): string[] {
  const { values } = studio;
  const read = (name: string): unknown => values.of(`/dance/status/${name}`).value?.[0];
  const found: string[] = [];
  if (values.link.state.value !== "open") return ["No connection to the engine"];
  if (late) found.push(late === 1 ? "A picture came late" : `${late} pictures came late: other programs may want this machine`);
  const state = String(read("clock") ?? "");
  if (state === "lost" || state === "absent") found.push("The beat is lost: tap, or say which beat is one");
  if (values.refused.value) found.push(`Refused: ${values.refused.value}`);
  return found;
}
