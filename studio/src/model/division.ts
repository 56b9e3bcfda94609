// The danced division of a range of measures, as rows: groups, and below each the parts into which it divides.
import type { Box, Row } from "./plan";

export interface Branch {
  words: string;
  dancers: number[];
  /** Measures from 1, as danced. */
  from: number;
  to: number;
  parts: Branch[];
}

const MOST_ROWS = 60;

/** Rows of the branches; `first`: the written measure (from 0) at which the danced measure `danced` (from 1) comes. */
export function divisionRows(branches: Branch[], first: number, danced: number): Row[] {
  const rows: Row[] = [];
  const byWords = new Map<string, Row>();
  const add = (branch: Branch, depth: number, above: string): void => {
    const id = `danced ${above}/${branch.words}`;
    let row = byWords.get(id);
    if (!row) {
      if (rows.length >= MOST_ROWS) return;
      row = { id, label: branch.words, kind: "danced", selection: null, group: -1, depth, boxes: [], apart: [], lanes: 1, lane: new Map() };
      byWords.set(id, row);
      rows.push(row);
    }
    const count = branch.dancers.length;
    const box: Box = {
      list: "danced", number: row.boxes.length + 1, entry: {}, start: first + branch.from - danced, length: Math.max(branch.to - branch.from + 1, 0.25),
      label: `${count} ${count === 1 ? "dancer" : "dancers"}`, group: branch.words,
    };
    row.boxes.push(box);
    row.lane.set(box, 0);
    for (const part of branch.parts) add(part, depth + 1, id);
  };
  for (const branch of branches) add(branch, 0, "");
  return rows;
}
