import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { asLed } from "../../model/danced";
import type { Studio } from "../../model/studio";
import { isLed, measuresText, neighbours, pictures, placeText, ranges, takenAt, title, type Picture, type Taken } from "../../model/storyboard";
import { groupOf } from "../stage/stage_view";
import { BoardPicture } from "./board_picture";
import "./storyboard.css";

/** The show in pictures, one for each arrival; printed as it is, or as a sheet for each dancer. */
export function Storyboard({ studio }: { studio: Studio }) {
  const taken = useSignal<Map<number, Taken>>(new Map());
  const problem = useSignal("");
  const dancer = useSignal<number | null>(null);
  const structure = studio.doc.structure.value;
  const all = useMemo(() => (structure ? pictures(structure) : []), [structure]);
  const led = structure !== null && isLed(structure);

  useEffect(() => {
    let wanted = true;
    void (async () => {
      const found = new Map<number, Taken>();
      for (const [from, to] of ranges(all)) {
        const answer = await studio.preview.ask({ from, to, ...asLed(led), positions: "measures", ways: false, notes: false }, "storyboard");
        if (!wanted) return;
        if (answer.refused) {
          problem.value = answer.refused[0]?.what ?? "";
          return;
        }
        for (const [measure, one] of takenAt(answer)) found.set(measure, one);
        taken.value = new Map(found);
      }
      problem.value = "";
    })();
    return () => { wanted = false; };
  }, [all]);

  const count = structure?.groups.reduce((sum, group) => sum + group.dancers, 0) ?? 0;
  const shown = dancer.value === null ? [null] : dancer.value === 0 ? Array.from({ length: count }, (_, index) => index + 1) : [dancer.value];
  return (
    <main class="storyboard">
      <header class="strip">
        <h2>Storyboard</h2>
        <label class="field">
          For
          <select value={String(dancer.value ?? "")} onChange={(event) => { dancer.value = event.currentTarget.value === "" ? null : Number(event.currentTarget.value); }}>
            <option value="">everybody</option>
            <option value="0">each dancer, a sheet each</option>
            {Array.from({ length: count }, (_, index) => <option key={index} value={String(index + 1)}>dancer {index + 1}</option>)}
          </select>
        </label>
        <button onClick={() => print()}>Print</button>
        <span class="hint" role="status">{problem.value || (all.some((one) => !taken.value.has(one.danced)) ? studio.preview.progress.value !== null ? `Simulating: ${studio.preview.progress.value} measures so far` : "The pictures come in a moment …" : countText(all.length, led))}</span>
      </header>
      {shown.map((one) => <Sheet key={one ?? "all"} studio={studio} all={all} taken={taken.value} dancer={one} />)}
    </main>
  );
}

function countText(count: number, led: boolean): string {
  return `${count} ${count === 1 ? "picture" : "pictures"}${led ? ", as somebody leads from section to section" : ""}`;
}

function Sheet({ studio, all, taken, dancer }: { studio: Studio; all: Picture[]; taken: Map<number, Taken>; dancer: number | null }) {
  const structure = studio.doc.structure.value;
  if (!structure) return null;
  const groups = groupOf(studio, structure.groups.reduce((sum, group) => sum + group.dancers, 0) + 64);
  const name = String(structure.score["name"] ?? "");
  const group = dancer === null ? undefined : structure.groups[groups[dancer - 1] ?? 0];
  return (
    <article class="sheet">
      <h3>{dancer === null ? name : `${name}: dancer ${dancer}${group ? `, ${group.name}` : ""}`}</h3>
      <ol>
        {all.map((picture, index) => {
          const here = taken.get(picture.danced);
          const before = index ? (taken.get((all[index - 1] as Picture).danced) ?? null) : null;
          return (
            <li key={picture.last}>
              <button
                class="plain shot" aria-label={`${measuresText(picture)}: ${title(picture)}`}
                onClick={() => { studio.view.value = "make"; studio.cursor.value = Math.max(0, picture.last - 1); if (picture.boxes[0]) studio.select(picture.boxes[0]); }}
              >
                {here ? <BoardPicture studio={studio} taken={here} before={before} groupOf={groups} dancer={dancer} /> : <div class="board empty" />}
              </button>
              <p><b>{measuresText(picture)}</b>{picture.section ? ` · ${picture.section}` : ""}</p>
              <p>{title(picture)}</p>
              {here && dancer !== null && <Own taken={here} dancer={dancer} structure={structure} />}
            </li>
          );
        })}
      </ol>
    </article>
  );
}

function Own({ taken, dancer, structure }: { taken: Taken; dancer: number; structure: NonNullable<Studio["doc"]["structure"]["value"]> }) {
  if (!taken.present[dancer - 1]) return <p>not on the stage</p>;
  const { left, right } = neighbours(taken, dancer);
  const beside = [left && `${left} at the left`, right && `${right} at the right`].filter(Boolean).join(", ");
  return (
    <>
      <p>{placeText(taken.rows[3 * (dancer - 1)] ?? 0, taken.rows[3 * (dancer - 1) + 1] ?? 0, structure)}</p>
      {beside && <p>beside {beside}</p>}
      <p>{taken.steps[dancer - 1]}</p>
    </>
  );
}
