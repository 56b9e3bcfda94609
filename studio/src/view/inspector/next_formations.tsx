import { useSignal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { asLed, reached, writtenStart } from "../../model/danced";
import type { Studio } from "../../model/studio";

interface Suggestion {
  formation: string;
  measures: number;
  longest_m: number;
  meetings: number;
  segment: Record<string, unknown>;
}

interface Told {
  after: number;
  quiet: number | null;
  formations: Suggestion[];
}

/** What could follow an element, from where its dancers stand then: each click puts a formation behind it. Asked for when
 * it is opened, as the measures before are simulated. */
export function NextFormations({ studio, number }: { studio: Studio; number: number }) {
  const open = useSignal(false);
  const [told, setTold] = useState<Told | null>(null);
  const asked = open.value ? studio.doc.revision.value : null;
  useEffect(() => {
    if (asked === null) return undefined;
    let left = false;
    const score = studio.score.peek();
    const { led } = reached(score, writtenStart(score, studio.entry({ list: "element", number }) ?? {}, studio.beats.peek()));
    void studio.library.ask({ element: number, ...asLed(led) }).then((answer) => {
      if (!left) setTold((answer.texts["next"] as Told | undefined) ?? { after: 0, quiet: null, formations: [] });
    });
    return () => { left = true; };
  }, [studio, number, asked]);
  return (
    <details class="more" onToggle={(event) => { open.value = event.currentTarget.open; }}>
      <summary>What could come next</summary>
      {!told && <p class="hint" role="status">The measures before it are danced …</p>}
      {told?.formations.map((one) => (
        <button
          key={one.formation} title={`From measure ${told.after} on; the longest way is ${one.longest_m.toFixed(1)} m`}
          onClick={() => void studio.doc.edit({ do: "insert", at: ["segment"], value: one.segment })}
        >
          {one.formation}, {inMeasures(one.measures)}
        </button>
      ))}
      {told?.formations.length === 0 && <p class="hint">{told.quiet === 0 ? "Something moves its dancers at once." : "No formation is within reach of its dancers."}</p>}
    </details>
  );
}

function inMeasures(count: number): string {
  return count === 1 ? "1 measure" : `${count} measures`;
}
