// What the pointer does in the timeline: one set of listeners for all rows, which finds boxes by their keys.
import { FIXED, POINTS, snappedMove, unitOf } from "../../model/arrange";
import type { Box } from "../../model/plan";
import type { Studio } from "../../model/studio";
import type { TimelineState } from "./state";

const EDGE_PX = 8;
const SLACK_PX = 4;
/** A finger that rests so long adds a box to the selection, or begins a box around several. */
const LONG_PRESS_MS = 450;
const DOUBLE_TAP_MS = 350;
const DOUBLE_TAP_PX = 24;

interface Held {
  pointer: number;
  x: number;
  y: number;
  measure: number;
  row: number;
  moved: boolean;
  begin: (event: PointerEvent) => void;
  move: (event: PointerEvent) => void;
  click: (event: PointerEvent) => void;
  /** A finger rested on it. */
  rest: () => void;
}

type Hold = Pick<Held, "begin" | "move" | "click"> & Partial<Pick<Held, "rest">>;

/** Listen to mouse, pen and fingers; `double` is told of a double tap, which browsers do not tell alike. */
export function listenToGestures(studio: Studio, state: TimelineState, element: HTMLElement, double: (event: PointerEvent) => void): () => void {
  let held: Held | null = null;
  let pinch: { distance: number; scale: number } | null = null;
  let tapped: { time: number; x: number; y: number } | null = null;

  const boxOf = (target: Element): Box | undefined => {
    const [list = "", number = ""] = target.closest<HTMLElement>("[data-key]")?.dataset["key"]?.split(" ") ?? [];
    return list ? studio.box({ list, number: Number(number) }) : undefined;
  };

  const holdBox = (event: PointerEvent, box: Box): Hold => {
    const scale = studio.scale.peek();
    const inside = state.place(event).x - box.start * scale;
    const width = box.length * scale;
    const sized = !POINTS.includes(box.list) && box.list !== "curve" && width > 3 * EDGE_PX;
    const edge = sized && inside > width - EDGE_PX ? "end" : sized && inside < EDGE_PX ? "begin" : null;
    const more = event.shiftKey || event.ctrlKey || event.metaKey;
    const wasChosen = studio.isSelected(box);
    const before = studio.selected.peek();
    if (!wasChosen) studio.select(box, more);
    const unit = unitOf(box.list, studio.snap.peek(), studio.beats.peek());
    return {
      begin: (now) => {
        if (FIXED.includes(box.list)) return;
        const boxes = studio.isSelected(box) ? studio.chosenBoxes().filter((one) => !FIXED.includes(one.list)) : [box];
        state.gesture.value = edge ? { kind: edge, boxes, by: 0 } : { kind: "move", boxes, from: held?.row ?? 0, by: 0, rows: 0, copy: now.altKey };
      },
      move: (now) => {
        const gesture = state.gesture.peek();
        const place = state.place(now);
        const wish = place.measure - (held?.measure ?? 0);
        if (gesture?.kind === "move") {
          const first = Math.min(...gesture.boxes.map((one) => one.start));
          const by = Math.max(snappedMove(box, wish, gesture.boxes.some((one) => unitOf(one.list, "none", studio.beats.peek()) === 1) ? 1 : unit), -first);
          const places = state.rows.peek().flatMap((one, index) => (one.selection !== null && one.kind !== "danced" ? [index] : []));
          const rows = places.includes(gesture.from) && places.includes(place.row) ? places.indexOf(place.row) - places.indexOf(gesture.from) : 0;
          if (by !== gesture.by || rows !== gesture.rows || now.altKey !== gesture.copy) state.gesture.value = { ...gesture, by, rows, copy: now.altKey };
        } else if (gesture?.kind === "end" || gesture?.kind === "begin") {
          const sign = gesture.kind === "end" ? 1 : -1;
          const shortest = Math.min(...gesture.boxes.map((one) => one.length));
          const earliest = Math.min(...gesture.boxes.map((one) => one.start));
          let by = Math.round(wish / unit) * unit;
          by = sign > 0 ? Math.max(by, unit - shortest) : Math.max(Math.min(by, shortest - unit), -earliest);
          if (by !== gesture.by) state.gesture.value = { ...gesture, by };
        }
        state.ask();
      },
      click: () => {
        if (wasChosen) studio.select(box, more);
        state.focus(box);
      },
      rest: () => {
        const others = before.filter((one) => one.list !== box.list || one.number !== box.number);
        studio.selected.value = wasChosen ? others : [...before, { list: box.list, number: box.number }];
      },
    };
  };

  const holdCanon = (key: string): Hold => {
    const [list = "", text = ""] = key.split(" ");
    const number = Number(text);
    const box = studio.box({ list, number });
    const row = list === "group" ? state.rows.peek().findIndex((one) => one.kind === "group" && one.group === number - 1) : state.rowOf({ list, number });
    const start = list === "group" ? 0 : (box?.start ?? 0);
    const grid = list === "group" || studio.snap.peek() !== "none" ? 1 : 0.25;
    return {
      begin: () => { state.gesture.value = { kind: "canon", list, number, start, beats: 0, row }; },
      move: (now) => {
        const gesture = state.gesture.peek();
        if (gesture?.kind !== "canon") return;
        const beats = Math.max(0, Math.round(((state.place(now).measure - start) * studio.beats.peek()) / grid) * grid);
        if (beats !== gesture.beats) state.gesture.value = { ...gesture, beats };
        state.ask();
      },
      click: () => {},
    };
  };

  const holdSection = (event: PointerEvent, target: HTMLElement): Hold => {
    const span = studio.spans.peek()[Number(target.dataset["section"]) - 1];
    const atEnd = event.clientX > target.getBoundingClientRect().right - EDGE_PX && target.offsetWidth > 3 * EDGE_PX;
    return {
      begin: () => {
        if (span) state.gesture.value = { kind: "section", number: span.number, start: span.first, measures: span.measures, to: null };
      },
      move: (now) => {
        const gesture = state.gesture.peek();
        if (gesture?.kind !== "section" || !span) return;
        const by = Math.round(state.place(now).measure - (held?.measure ?? 0));
        if (atEnd) state.gesture.value = { ...gesture, measures: Math.max(1, span.measures + by) };
        else {
          const middle = span.first + by + span.measures / 2;
          const to = studio.spans.peek().filter((one) => one.number !== span.number && one.first + one.measures / 2 < middle).length + 1;
          state.gesture.value = { ...gesture, start: Math.max(0, span.first + by), to: to === span.number ? null : to };
        }
      },
      click: (now) => studio.select({ list: "section", number: span?.number ?? 1 }, now.shiftKey),
    };
  };

  const holdRuler = (measure: number): Hold => {
    const grid = studio.snap.peek() === "beat" ? 1 / studio.beats.peek() : 1;
    return {
      begin: () => {},
      move: (now) => {
        const to = state.place(now).measure;
        const first = Math.floor(Math.min(measure, to) / grid) * grid;
        const last = Math.ceil(Math.max(measure, to) / grid) * grid;
        studio.range.value = last > first ? [first, last] : null;
      },
      click: () => {
        studio.cursor.value = Math.floor(measure / grid) * grid;
        studio.range.value = null;
      },
    };
  };

  const holdGround = (event: PointerEvent): Hold => {
    const more = event.shiftKey;
    const before = more ? studio.selected.peek() : [];
    const from = state.place(event);
    const beginMarquee = (): void => { state.gesture.value = { kind: "marquee", x: [from.x, from.x], y: [from.y, from.y] }; };
    return {
      begin: () => { if (event.pointerType !== "touch") beginMarquee(); },
      rest: beginMarquee,
      move: (now) => {
        const gesture = state.gesture.peek();
        if (gesture?.kind !== "marquee") return;
        const to = state.place(now);
        state.gesture.value = { kind: "marquee", x: [Math.min(from.x, to.x), Math.max(from.x, to.x)], y: [Math.min(from.y, to.y), Math.max(from.y, to.y)] };
        const found = boxesIn(studio, state, state.gesture.value as never);
        studio.selected.value = [...before, ...found.filter((box) => !before.some((one) => one.list === box.list && one.number === box.number))];
      },
      click: () => {
        if (!more) studio.select(null);
        const row = state.rows.peek()[from.row];
        if (row?.selection !== null && row?.kind !== "danced") studio.row.value = row?.id ?? null;
        const grid = studio.snap.peek() === "beat" ? 1 / studio.beats.peek() : 1;
        studio.cursor.value = Math.floor(from.measure / grid) * grid;
      },
    };
  };

  const onDown = (event: PointerEvent): void => {
    if (event.button !== 0 || held) return;
    const target = event.target as HTMLElement;
    if (target.closest("input, .knot, .name, [data-plain]")) return;
    const place = state.place(event);
    const box = boxOf(target) ?? (place.row >= 0 && target.closest(".lane") ? state.boxAt(place) : undefined);
    const canon = target.closest<HTMLElement>("[data-canon]")?.dataset["canon"];
    const section = target.closest<HTMLElement>("[data-section]");
    const isBox = Boolean(box || canon || section);
    const own = canon ? holdCanon(canon)
      : section ? holdSection(event, section)
      : box ? holdBox(event, box)
      : place.row < 0 ? holdRuler(place.measure)
      : target.closest(".lane") ? holdGround(event)
      : null;
    if (!own) return;
    const mine: Held = { pointer: event.pointerId, x: event.clientX, y: event.clientY, measure: place.measure, row: place.row, moved: false, rest: () => {}, ...own };
    held = mine;
    if (isBox || event.pointerType !== "touch" || place.row < 0) {
      element.setPointerCapture(event.pointerId);
      if (!isBox) event.preventDefault();
    }
    if (event.pointerType === "touch" && own.rest) {
      window.setTimeout(() => {
        if (held !== mine || mine.moved) return;
        mine.click = () => { state.gesture.value = null; };
        mine.begin = () => {}; // from here on the finger does what the rest began; a box stays where it is
        if (box) mine.move = () => {};
        mine.rest();
      }, LONG_PRESS_MS);
    }
  };
  const onMove = (event: PointerEvent): void => {
    if (!held || event.pointerId !== held.pointer) return;
    if (!held.moved) {
      if (Math.hypot(event.clientX - held.x, event.clientY - held.y) < SLACK_PX) return;
      held.moved = true;
      held.begin(event);
    }
    held.move(event);
    autoScroll(event);
  };
  const onUp = (event: PointerEvent): void => {
    if (!held || event.pointerId !== held.pointer) return;
    const own = held;
    held = null;
    if (own.moved) {
      void finish(studio, state);
      return;
    }
    own.click(event);
    if (event.pointerType !== "touch") return;
    const twice = tapped !== null && event.timeStamp - tapped.time < DOUBLE_TAP_MS && Math.hypot(event.clientX - tapped.x, event.clientY - tapped.y) < DOUBLE_TAP_PX;
    tapped = twice ? null : { time: event.timeStamp, x: event.clientX, y: event.clientY };
    if (twice) double(event);
  };
  const stop = (): void => {
    held = null;
    void state.end(false);
  };
  const autoScroll = (event: PointerEvent): void => {
    const border = element.getBoundingClientRect();
    const right = event.clientX - border.right + 36;
    const left = border.left + state.names.peek() + 24 - event.clientX;
    if (right > 0) element.scrollLeft += Math.min(right, 24);
    else if (left > 0) element.scrollLeft -= Math.min(left, 24);
  };
  const onKey = (event: KeyboardEvent): void => {
    if (event.key === "Escape" && state.gesture.peek()) {
      event.stopPropagation();
      stop();
    }
  };
  const onWheel = (event: WheelEvent): void => {
    if (!event.ctrlKey && !event.metaKey) {
      if (event.deltaX || event.shiftKey) state.follow.value = false;
      return;
    }
    event.preventDefault();
    state.zoom(Math.exp(-event.deltaY / 300), event.clientX);
  };
  const onTouch = (event: TouchEvent): void => {
    const [a, b] = [event.touches[0], event.touches[1]];
    if (!a || !b) {
      pinch = null;
      if (state.gesture.peek()?.kind === "marquee" && event.cancelable) event.preventDefault(); // not scrolled
      return;
    }
    event.preventDefault();
    const distance = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    if (pinch) state.zoom((pinch.scale * distance) / pinch.distance / studio.scale.peek(), (a.clientX + b.clientX) / 2);
    else pinch = { distance: Math.max(distance, 1), scale: studio.scale.peek() };
  };
  const onClick = (event: MouseEvent): void => {
    const box = event.detail === 0 ? boxOf(event.target as Element) : undefined; // by keyboard, or for a screen reader
    if (box) studio.select(box, event.shiftKey);
  };
  element.addEventListener("click", onClick);
  element.addEventListener("pointerdown", onDown);
  element.addEventListener("pointermove", onMove);
  element.addEventListener("pointerup", onUp);
  element.addEventListener("pointercancel", stop);
  document.addEventListener("keydown", onKey, true);
  element.addEventListener("wheel", onWheel, { passive: false });
  element.addEventListener("touchstart", onTouch, { passive: false });
  element.addEventListener("touchmove", onTouch, { passive: false });
  element.addEventListener("touchend", onTouch);
  return () => {
    element.removeEventListener("click", onClick);
    element.removeEventListener("pointerdown", onDown);
    element.removeEventListener("pointermove", onMove);
    element.removeEventListener("pointerup", onUp);
    element.removeEventListener("pointercancel", stop);
    document.removeEventListener("keydown", onKey, true);
    element.removeEventListener("wheel", onWheel);
    element.removeEventListener("touchstart", onTouch);
    element.removeEventListener("touchmove", onTouch);
    element.removeEventListener("touchend", onTouch);
  };
}

async function finish(studio: Studio, state: TimelineState): Promise<void> {
  const gesture = state.gesture.peek();
  if (gesture?.kind !== "section") {
    await state.end(true);
    return;
  }
  state.gesture.value = null;
  const at = ["section", gesture.number];
  const span = studio.spans.peek()[gesture.number - 1];
  if (gesture.to !== null) await studio.doc.edit({ do: "move", at, value: { number: gesture.to } });
  else if (span && gesture.measures !== span.measures) await studio.doc.edit({ do: "resize", at, value: gesture.measures });
}

function boxesIn(studio: Studio, state: TimelineState, area: { x: [number, number]; y: [number, number] }): { list: string; number: number }[] {
  const scale = studio.scale.peek();
  const [from, to] = [area.x[0] / scale, area.x[1] / scale];
  const rows = state.rows.peek();
  const first = state.rowAt(area.y[0]);
  const last = state.rowAt(area.y[1]);
  return rows.slice(first, last + 1).flatMap((row) =>
    row.kind === "danced" ? [] : row.boxes.filter((box) => box.start < to && box.start + Math.max(box.length, 4 / scale) > from).map(({ list, number }) => ({ list, number })));
}
