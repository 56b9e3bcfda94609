import { nextCall, nextInWords, type When } from "../../model/pads";
import type { Studio } from "../../model/studio";
import { PadPicture } from "./pad_picture";

/** After a crossing or another element: formations that its dancers could go into, a pad for each. Below the pads, so
 * that none moves under a finger. */
export function WhatNext({ studio, when }: { studio: Studio; when: When }) {
  const next = studio.doc.launches.value.next;
  if (!next) return null;
  return (
    <div class="whatnext" role="group" aria-label="What could come next">
      <span class="hint">{nextInWords(next)}</span>
      {next.pads.map((pad, index) => (
        <button
          key={pad.pad} class="pad" title="Launched for as many measures as its dancers need"
          onClick={() => { const call = nextCall(next, index, when); if (call) studio.values.send(...call); }}
        >
          <span class="thumb"><PadPicture studio={studio} pad={{ pad: pad.pad, kind: "formation", name: pad.name, words: "" }} /></span>
          <span class="words"><b>{pad.name}</b><small>{pad.measures === 1 ? "1 measure" : `${pad.measures} measures`}</small></span>
        </button>
      ))}
    </div>
  );
}
