import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";

const A_SECOND = 4;

/** The picture as it is projected, a few times a second. */
export function Projected({ studio }: { studio: Studio }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { doc } = studio;
  useEffect(() => {
    doc.want({ picture: A_SECOND });
    const stop = doc.picture.subscribe((picture) => {
      if (!picture) return;
      createImageBitmap(picture.jpeg).then(
        (bitmap) => {
          const element = canvas.current;
          if (element) {
            if (element.width !== bitmap.width || element.height !== bitmap.height) [element.width, element.height] = [bitmap.width, bitmap.height];
            element.getContext("2d")?.drawImage(bitmap, 0, 0);
          }
          bitmap.close();
        },
        () => undefined, // a damaged picture: the next one comes soon
      );
    });
    return () => {
      stop();
      doc.picture.value = null;
      doc.want({ picture: 0 });
    };
  }, [doc]);
  const there = doc.picture.value !== null;
  return (
    <figure class="projected" aria-label="As projected">
      <canvas ref={canvas} role="img" aria-label="The picture as it is projected" hidden={!there} />
      <figcaption>{there ? "As projected" : "No projector: this show runs without a window"}</figcaption>
    </figure>
  );
}
