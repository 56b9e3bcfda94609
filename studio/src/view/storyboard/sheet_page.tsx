import { useMemo } from "preact/hooks";
import { svgPoints, type SheetItem, type SheetPage, type SheetScene } from "../../model/sheets";

const ANCHORS = { l: "start", m: "middle", r: "end" } as const;

/** A page of a sheet as the engine laid it out, drawn sharp at every size; its scenes are buttons. */
export function PageOfSheet({ page, scenes, label, look }: { page: SheetPage; scenes: SheetScene[]; label: string; look: (scene: SheetScene) => void }) {
  const drawn = useMemo(() => <svg viewBox={`0 0 ${page.width} ${page.height}`}>{page.items.map((item, index) => <Item key={index} item={item} />)}</svg>, [page]);
  return (
    <article class="sheet" aria-label={label} style={{ aspectRatio: `${page.width} / ${page.height}` }}>
      {drawn}
      {page.areas.map(([number, x, y, width, height]) => {
        const scene = scenes[number - 1];
        if (!scene) return null;
        const share = (value: number, whole: number): string => `${(100 * value) / whole}%`;
        return (
          <button
            key={number} class="scene" aria-label={`Scene ${number}, ${scene.words}: look at it in Make`} title="Look at it in Make"
            style={{ left: share(x, page.width), top: share(y, page.height), width: share(width, page.width), height: share(height, page.height) }}
            onClick={() => look(scene)}
          />
        );
      })}
    </article>
  );
}

function Item({ item }: { item: SheetItem }) {
  switch (item[0]) {
    case "stroke": {
      const [, points, width, ink, dash] = item;
      return <polyline points={svgPoints(points)} fill="none" stroke={ink} stroke-width={width} {...(dash ? { "stroke-dasharray": `${dash} ${dash}` } : {})} />;
    }
    case "shape": {
      const [, points, fill, ink, width] = item;
      return <polygon points={svgPoints(points)} fill={fill ?? "none"} stroke={ink ?? "none"} stroke-width={width} />;
    }
    case "disc": {
      const [, x, y, radius, fill, ink, width] = item;
      return <circle cx={x} cy={y} r={radius} fill={fill ?? "none"} stroke={ink ?? "none"} stroke-width={width} />;
    }
    case "words": {
      const [, x, y, size, width, words, bold, ink, anchor] = item;
      return (
        <text x={x} y={y} font-size={size} font-weight={bold ? 700 : 400} fill={ink} text-anchor={ANCHORS[anchor]} {...(width > 0 ? { textLength: width, lengthAdjust: "spacingAndGlyphs" } : {})}>
          {words}
        </text>
      );
    }
  }
}
