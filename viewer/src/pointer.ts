// Mouse and fingers on a map: a drag moves it, the wheel and two fingers zoom, a click or a tap means a place.

import type { Point } from "./hex";
import type { Stage } from "./stage";

const STEADY_PX = 4; // a hand that moves less has clicked

export interface Pointed {
  stage(): Stage;
  ask(): void;
  grabbed?(): void;
  panned?(): void;
  hovered(here: Point): void;
  left(): void;
  clicked(here: Point, event: PointerEvent): void;
}

export function listenPointer(canvas: HTMLCanvasElement, target: Pointed): void {
  const fingers = new Map<number, Point>();
  let moved = 0;
  const place = (event: PointerEvent | WheelEvent) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    target.stage().camera.zoom(Math.exp(-event.deltaY * 0.0016), place(event));
    target.ask();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
    moved = 0;
    target.grabbed?.();
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = place(event);
    const last = fingers.get(event.pointerId);
    if (!last) return target.hovered(here);
    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    moved += Math.hypot(here.x - last.x, here.y - last.y);
    if (others.length === 1) {
      const [a] = others;
      target.stage().camera.zoom(Math.hypot(here.x - a.x, here.y - a.y) / Math.max(1, Math.hypot(last.x - a.x, last.y - a.y)), a);
    } else if (moved > STEADY_PX) {
      target.panned?.();
      target.stage().camera.pan(here.x - last.x, here.y - last.y);
    }
    fingers.set(event.pointerId, here);
    target.ask();
  });
  const lift = (event: PointerEvent) => {
    if (fingers.delete(event.pointerId) && moved <= STEADY_PX && event.type === "pointerup") target.clicked(place(event), event);
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointerleave", () => target.left());
}
