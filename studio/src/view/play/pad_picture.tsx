import { dancersOf } from "../../model/formations";
import type { Pad } from "../../model/pads";
import { entries, text, type Score } from "../../model/score";
import type { Studio } from "../../model/studio";
import { SmallFigure } from "../library/figure";
import { FormationPicture, usePlaces } from "../library/formation_picture";

/** What a pad does, as a small picture. */
export function PadPicture({ studio, pad }: { studio: Studio; pad: Pad }) {
  const name = pad.does ?? pad.name;
  switch (pad.kind) {
    case "step": return <SmallFigure studio={studio} name={name} />;
    case "formation": return <PlacesPicture studio={studio} name={name} />;
    case "phrase": return <PhrasePicture words={pad.does ? phraseSteps(studio, name) : pad.words} />;
    case "element": return <ElementPicture name={name} />;
    default: return <LookPicture score={studio.score.value} kind={pad.kind} name={name} />;
  }
}

function PlacesPicture({ studio, name }: { studio: Studio; name: string }) {
  return <FormationPicture studio={studio} places={usePlaces(studio, name, dancersOf(studio.doc.structure.value, ""))} />;
}

function phraseSteps(studio: Studio, name: string): string {
  return studio.doc.pads.value?.phrase.find((pad) => pad.name === name)?.words ?? "";
}

const MOST_STEPS = 8;

/** A phrase as blocks, one for each step; the same step has the same height. */
function PhrasePicture({ words }: { words: string }) {
  const names = words.split(",").flatMap((part) => {
    const [, name = "", times = "1"] = /^\s*(.*?)(?:\s+x(\d+))?\s*$/.exec(part) ?? [];
    return Array.from({ length: Math.min(Number(times), MOST_STEPS) }, () => name);
  }).slice(0, MOST_STEPS);
  const kinds = [...new Set(names)];
  return (
    <svg viewBox="0 0 48 40" aria-hidden="true" class="phrase">
      {names.map((name, index) => {
        const height = 12 + (20 * (kinds.indexOf(name) + 1)) / kinds.length;
        return <rect key={index} x={2 + (index * 44) / names.length} y={36 - height} width={44 / names.length - 1.5} height={height} rx="1.5" />;
      })}
    </svg>
  );
}

const MARKS: Record<string, string> = {
  attract: "M6 6l9 7M42 6l-9 7M6 34l9-7M42 34l-9-7M15 13l-1-5M15 13l-5 0M33 13l1-5M33 13l5 0M15 27l-1 5M15 27l-5 0M33 27l1 5M33 27l5 0",
  repel: "M16 14L7 7M32 14l9-7M16 26l-9 7M32 26l9 7M7 7l1 5M7 7l5 0M41 7l-1 5M41 7l-5 0M7 33l1-5M7 33l5 0M41 33l-1-5M41 33l-5 0",
  spread: "M8 8h.1M24 8h.1M40 8h.1M8 20h.1M24 20h.1M40 20h.1M8 32h.1M24 32h.1M40 32h.1",
  cross: "M24 4v32M12 14h24M31 9l5 5l-5 5M36 27H12M17 22l-5 5l5 5",
  vortex: "M36 20a12 12 0 1 1-5-9.700M31 4v7h-7",
  wander: "M5 30c6-18 12-18 14-8s8 12 12 0s6-14 12-12",
  flock: "M8 28l7-4l-7-4M20 20l7-4l-7-4M20 36l7-4l-7-4M32 28l7-4l-7-4M32 12l7-4l-7-4",
  pause: "M18 8v24M30 8v24",
};

function ElementPicture({ name }: { name: string }) {
  return <svg viewBox="0 0 48 40" aria-hidden="true" class="mark"><path d={MARKS[name] ?? ""} /></svg>;
}

/** The colours that a scene sets, as stripes; a cue has those of its scene. */
function LookPicture({ score, kind, name }: { score: Score; kind: string; name: string }) {
  const named = (list: string, wanted: string) => entries(score, list).find((one) => text(one, "name").toLowerCase() === wanted.toLowerCase());
  const scene = kind === "cue" ? named("scene", text(named("cue", name) ?? {}, "scene")) : named("scene", name);
  const set = (scene?.["set"] ?? {}) as Record<string, unknown>;
  const colours = Object.values(set).filter((value): value is number[] => Array.isArray(value) && value.length === 3 && value.every((each) => typeof each === "number" && each >= 0 && each <= 1)).slice(0, 4);
  const level = typeof set["/dance/light/level"] === "number" ? Math.min(set["/dance/light/level"], 1) : 1;
  if (!colours.length) colours.push([1, 0.93, 0.8]);
  return (
    <svg viewBox="0 0 48 40" aria-hidden="true" class="look">
      {colours.map((colour, index) => (
        <rect key={index} x={2 + (index * 44) / colours.length} y="4" width={44 / colours.length} height="32" fill={`rgb(${colour.map((value) => Math.round(255 * (value * level) ** (1 / 2.2))).join(" ")})`} />
      ))}
      {kind === "cue" && <path d="M19 12l12 8l-12 8z" />}
    </svg>
  );
}
