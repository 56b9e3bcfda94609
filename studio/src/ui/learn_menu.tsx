import { useEffect, useRef } from "preact/hooks";
import type { Values, Widget } from "../net/values";

/** The menu of a control: what moves it from outside. */
export function LearnMenu({ values, widget, at, onClose }: { values: Values; widget: Widget; at: { x: number; y: number }; onClose: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  useEffect(() => {
    (menu.current?.querySelector("button") as HTMLElement | null)?.focus();
    const away = (event: Event): void => {
      if (!menu.current?.contains(event.target as Node)) onClose();
    };
    document.addEventListener("pointerdown", away);
    return () => document.removeEventListener("pointerdown", away);
  }, []);
  const entry = (words: string, run: () => void) => (
    <button role="menuitem" onClick={() => { run(); onClose(); }}>{words}</button>
  );
  return (
    <div
      ref={menu} class="menu" role="menu" aria-label={widget.label} style={{ left: `${Math.min(at.x, innerWidth - 240)}px`, top: `${Math.min(at.y, innerHeight - 130)}px` }}
      onKeyDown={(event) => {
        if (event.key === "Escape") onClose();
        const all = [...(menu.current?.querySelectorAll("button") ?? [])] as HTMLElement[];
        const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
        if (step) {
          event.preventDefault();
          all[(all.indexOf(document.activeElement as HTMLElement) + step + all.length) % all.length]?.focus();
        }
        event.stopPropagation();
      }}
    >
      {entry("Learn MIDI: then move a fader or strike a pad", () => values.send("/dance/midi/learn", widget.address, ...(widget.kind === "button" ? widget.values.map(String) : [])))}
      {entry("Forget its MIDI", () => values.send("/dance/midi/forget", widget.address))}
      {entry(`Copy its OSC address ${widget.address}`, () => void navigator.clipboard?.writeText(widget.address))}
    </div>
  );
}
