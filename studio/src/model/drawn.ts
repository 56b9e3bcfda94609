// A line that is drawn on the stage: what it would become, shown while it is drawn and while its form is open.
import { reached } from "./danced";
import type { Places } from "./formations";
import type { Place } from "./geometry";
import { drawnGround, materials, type Material } from "./material";
import { drawnEdits, drawnFormation, freeName, type Drawn } from "./stage_edits";
import type { StageState, Stroke } from "./stage_state";

const MOST_DANCERS = 400;

/** A stroke with what becomes of it unless somebody says otherwise. */
export function drawnFrom(stage: StageState, stroke: Stroke): Drawn {
  const { studio } = stage;
  return {
    becomes: stage.becomes.value, points: stroke.points, closed: stroke.closed, start: stage.here(), measures: 4, group: studio.whom.value,
    name: freeName(studio.score.value, "drawn"), inside: false, pattern: "", many: "dancers", amount: 12, mirror: "", keep: "", singleFile: false, strength: 1,
    material: chosenMaterial(stage),
  };
}

/** The selected segment, from 1; 0: none, or several. */
export function chosenSegment(stage: StageState): number {
  const chosen = stage.studio.selected.value;
  return chosen.length === 1 && chosen[0]?.list === "segment" ? chosen[0].number : 0;
}

export function chosenMaterial(stage: StageState): Material | null {
  const all = materials(stage.studio.score.value, chosenSegment(stage));
  return all.find((one) => keyOfMaterial(one) === stage.bent.value) ?? all[0] ?? null;
}

export function keyOfMaterial(material: Material): string {
  return material.segment ? "selected" : `${material.list} ${material.name}`;
}

/** Show what a line would become: the places of its formation, and the ways of all, planned together. */
export function showDrawn(stage: StageState, drawn: Drawn): void {
  const { studio } = stage;
  stage.refusal.value = [];
  stage.drawn.value = drawn.becomes === "bend" && drawn.material?.segment ? String(studio.entry({ list: "segment", number: drawn.material.segment })?.["group"] ?? "*") : drawn.group;
  if (drawn.becomes === "bend") {
    if (drawn.material) stage.bending.show(drawn.material, drawnGround(drawn.points, drawn.closed), drawn);
    return;
  }
  if (drawn.becomes === "formation") {
    void placesOf(stage, drawn).then((places) => { if (stage.drawn.peek()) stage.thought.value = places; });
  } else stage.thought.value = [];
  if (drawn.becomes === "formation" || drawn.becomes === "way") stage.drag(drawnEdits(studio.score.value, drawn), reached(studio.score.value, drawn.start, drawn.measures));
  else stage.endDrag();
}

/** Nothing is drawn any more. */
export function hideDrawn(stage: StageState): void {
  stage.drawn.value = "";
  stage.bending.cancel();
}

async function placesOf({ studio }: StageState, drawn: Drawn): Promise<Place[]> {
  const count = studio.dancers.value.length || (studio.doc.structure.value?.groups ?? []).reduce((sum, group) => sum + group.dancers, 0);
  const answer = await studio.preview.ask({ places: [{ formation: drawnFormation(drawn), dancers: Math.min(count, MOST_DANCERS) }] }, "places");
  const rows = answer.texts["places"]?.["places"] as Places[] | undefined;
  return (rows?.[0]?.slots ?? []).map((slot): Place => [slot[0], slot[1]]);
}
