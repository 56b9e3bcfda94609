import { useEffect, useState } from "preact/hooks";
import type { Motion } from "../../model/figure";
import { takeInWords, takesEdit, type StepFacts } from "../../model/steps";
import type { Studio } from "../../model/studio";
import { Figure } from "./figure";

/** Takes whose motion is asked for at once. */
const AT_ONCE = 4;
const MOST = 12;

/** The takes of a step side by side, textured ones too, to choose from (Pullen and Bregler, figure 12): the show dances those that are checked. */
export function TakesGallery({ studio, facts, onLook }: { studio: Studio; facts: StepFacts; onLook: (take: number) => void }) {
  const [motions, setMotions] = useState<(Motion | undefined)[]>([]);
  const shown = facts.takes.map((take, index) => ({ take, number: index + 1 })).filter(({ take }) => !take.mirrored).slice(0, MOST);
  const numbers = shown.map((one) => one.number).join();
  useEffect(() => {
    let left = false;
    const load = async (): Promise<void> => {
      const all = numbers.split(",").map(Number);
      const found: (Motion | undefined)[] = [];
      for (let at = 0; at < all.length && !left; at += AT_ONCE) {
        found.push(...(await studio.library.motion(facts.name, all.slice(at, at + AT_ONCE))));
        if (!left) setMotions([...found]);
      }
    };
    void load();
    return () => { left = true; };
  }, [studio, facts.name, numbers]);
  const chosen = (studio.score.value["takes"] as Record<string, string[]> | undefined)?.[facts.name];
  return (
    <section class="gallery" aria-label="Takes">
      <h3>Takes <span class="hint">the show dances those that are checked{chosen ? ", from its next start on" : ""}</span></h3>
      <ul>
        {shown.map(({ take, number }, index) => {
          const words = takeInWords(take, number);
          const motion = motions[index];
          const isDanced = chosen?.includes(take.take) ?? true;
          return (
            <li key={number} class={isDanced ? "" : "left-out"}>
              <button class="plain" title={`Look at ${words}`} onClick={() => onLook(number)}>
                {motion ? <Figure studio={studio} motions={[motion]} look="front" still /> : <i class="figure" />}
              </button>
              <label class="switch">
                <input
                  type="checkbox" checked={isDanced} aria-label={`Dance take ${words}`}
                  onChange={(event) => {
                    const edit = takesEdit(facts, chosen, take.take, event.currentTarget.checked);
                    if (edit) void studio.doc.edit(edit);
                    else event.currentTarget.checked = isDanced; // one has to stay
                  }}
                />
                <span>{words}</span>
              </label>
            </li>
          );
        })}
      </ul>
    </section>
  );
}
