// The hand on the timeline: a click or a drag goes to a tick, a shift-drag makes a loop.

import { byId, say } from "./dom";
import type { Timeline } from "./timeline";

export interface Timed {
  readonly timeline: Timeline;
  seek(tick: number): void;
  ask(): void;
}

export function listenTimeline(page: Timed): void {
  const canvas = page.timeline.canvas;
  const tip = byId("tip");
  let start = -1;
  const at = (event: PointerEvent) => page.timeline.tickAt(event.clientX - canvas.getBoundingClientRect().left);
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    start = at(event);
    if (!event.shiftKey) page.seek(page.timeline.near(start) && event.pointerType === "mouse" ? snapped(page, start, event) : start);
  });
  canvas.addEventListener("pointermove", (event) => {
    const tick = at(event);
    page.timeline.hover = tick;
    if (start >= 0 && event.shiftKey) page.timeline.loop = [Math.min(start, tick), Math.max(start, tick) + 1];
    else if (start >= 0) page.seek(tick);
    const near = page.timeline.near(tick);
    tip.hidden = false;
    say(tip, near ? `${near.tick}: ${near.text}` : `tick ${tick}`);
    const box = canvas.getBoundingClientRect();
    tip.style.left = `${Math.max(6, Math.min(window.innerWidth - tip.offsetWidth - 8, event.clientX + 10))}px`;
    tip.style.top = `${box.top - tip.offsetHeight - 6}px`;
    page.ask();
  });
  canvas.addEventListener("pointerup", () => (start = -1));
  canvas.addEventListener("pointerleave", () => {
    page.timeline.hover = -1;
    tip.hidden = true;
    page.ask();
  });
}

/** A click on a mark goes to its tick. */
function snapped(page: Timed, tick: number, event: PointerEvent): number {
  const low = event.offsetY > page.timeline.canvas.clientHeight - 46;
  return low ? (page.timeline.near(tick)?.tick ?? tick) : tick;
}
