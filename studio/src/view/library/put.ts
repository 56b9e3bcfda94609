// Putting something of the library into the show: at the cursor, for the dancers who are selected.
import type { Studio } from "../../model/studio";
import type { Entry } from "../../model/score";
import { DRAGGED, dragging, putEntry } from "../timeline/timeline";

export interface Item {
  list: string;
  value: Entry;
}

export function drag(event: DragEvent, item: Item): void {
  dragging.now = item;
  event.dataTransfer?.setData(DRAGGED, JSON.stringify(item));
  if (event.dataTransfer) event.dataTransfer.effectAllowed = "copy";
}

export async function putAtCursor(studio: Studio, item: Item): Promise<void> {
  studio.mode.value = item.list === "sequence" ? "steps" : "motion";
  await putEntry(studio, item);
}

/** Keys of an entry in the library: Enter puts it at the cursor; a click, or the space bar, opens it. */
export function onEnter(put: () => void): (event: KeyboardEvent) => void {
  return (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    put();
  };
}
