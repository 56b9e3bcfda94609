// Putting something of the library into the show: at the cursor, for the dancers who are selected.
import type { Studio } from "../../model/studio";
import type { Entry } from "../../model/score";
import { DRAGGED, placeOf } from "../timeline/timeline";

export interface Item {
  list: string;
  value: Entry;
}

export function drag(event: DragEvent, item: Item): void {
  event.dataTransfer?.setData(DRAGGED, JSON.stringify(item));
  if (event.dataTransfer) event.dataTransfer.effectAllowed = "copy";
}

export async function putAtCursor(studio: Studio, item: Item): Promise<void> {
  const measure = studio.cursor.value ?? Math.floor(studio.playhead.value ?? 0);
  studio.mode.value = item.list === "sequence" ? "steps" : "motion";
  const group = studio.dancers.value.length ? { group: studio.dancers.value.join(" + ") } : {};
  await studio.insert(item.list, { ...item.value, ...placeOf(studio, measure), ...group });
}

/** Keys of an entry in the library: Enter puts it at the cursor; a click, or the space bar, opens it. */
export function onEnter(put: () => void): (event: KeyboardEvent) => void {
  return (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    put();
  };
}
