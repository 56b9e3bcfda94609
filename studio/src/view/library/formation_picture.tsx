import { useEffect, useState } from "preact/hooks";
import type { Places } from "../../model/formations";
import { stageSize } from "../../model/plan";
import type { Studio } from "../../model/studio";

/** The places of a formation, asked for whenever it, the number of dancers or the stage changes. */
export function usePlaces(studio: Studio, formation: unknown, dancers: number): Places | null {
  const [places, setPlaces] = useState<Places | null>(null);
  const { score } = studio.doc.structure.value ?? {};
  useEffect(() => {
    let left = false;
    void studio.library.placesOf(formation, dancers).then((found) => { if (!left) setPlaces(found); });
    return () => { left = true; };
  }, [studio, JSON.stringify(formation), dancers, score]);
  return places;
}

/** A formation from above, the public below. */
export function FormationPicture({ studio, places, label }: { studio: Studio; places: Places | null; label?: string }) {
  const stage = stageSize(studio.score.value);
  const radius = Math.max(stage.width, stage.depth) / 46;
  return (
    <svg class="formation" viewBox={`${-stage.width / 2 - 0.2} ${-stage.depth / 2 - 0.2} ${stage.width + 0.4} ${stage.depth + 0.4}`} {...(label ? { role: "img", "aria-label": label } : { "aria-hidden": true })}>
      <rect class="floorplan" x={-stage.width / 2} y={-stage.depth / 2} width={stage.width} height={stage.depth} />
      {places?.lines.map((line, index) => <polyline key={index} points={line.map(([x, z]) => `${x},${z}`).join(" ")} vector-effect="non-scaling-stroke" />)}
      {places?.slots.map(([x, z], index) => (
        <circle key={index} class={places.outside.includes(index + 1) ? "outside" : index < places.soloists ? "soloist" : ""} cx={x} cy={z} r={radius} />
      ))}
    </svg>
  );
}
