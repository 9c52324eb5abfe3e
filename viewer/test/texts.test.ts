import { expect, test } from "vitest";
import { Camera } from "../src/camera";
import { Labels } from "../src/labels";
import type { Entry } from "../src/log";
import { paletteOf } from "../src/palette";
import { lastOf, leadOf } from "../src/texts";
import type { Token } from "../src/tokens";

function entry(tick: number, group: Entry["group"]): Entry {
  return { tick, group, camp: "red", shape: "hit", text: `at ${tick}`, luck: null, from: -1, to: -1, dead: false, result: 1 };
}

test("who leads is who has the higher margin, where both are known", () => {
  expect(leadOf({ red: -78, blue: -182 })).toEqual({ camp: "red", points: 104 });
  expect(leadOf({ red: 0, blue: 3 })).toEqual({ camp: "blue", points: 3 });
  expect(leadOf({ red: 5, blue: 5 })).toBeNull();
  expect(leadOf({ red: 5 })).toBeNull();
});

test("the last thing that happened is fire or a first sight, no order", () => {
  const entries = [entry(3, "fire"), entry(5, "sight"), entry(5, "orders"), entry(9, "fire")];
  expect([0, 3, 4, 8, 9, 50].map((tick) => lastOf(entries, tick)?.tick)).toEqual([undefined, 3, 3, 5, 9, 9]);
  expect(lastOf([], 4)).toBeNull();
});

/** Where texts are written. */
function written(labels: Labels): { text: string; x: number; y: number }[] {
  const found: { text: string; x: number; y: number }[] = [];
  const fillText = (text: string, x: number, y: number) => found.push({ text, x, y: y - 0.5 });
  const ctx = new Proxy({}, { get: (_, name) => (name === "fillText" ? fillText : () => ({ width: 0 })), set: () => true });
  labels.draw(ctx as CanvasRenderingContext2D, paletteOf(false));
  return found;
}

test("a text on the map stands beside pieces and other texts, and away from buttons", () => {
  const camera = new Camera({ x: 10, y: 10 });
  camera.resize(400, 400);
  const ctx = { measureText: (text: string) => ({ width: text.length * 7 }) } as CanvasRenderingContext2D;
  const token = (x: number, y: number) => ({ at: { x, y }, size: 10 }) as Token;
  const labels = new Labels();
  labels.add(ctx, "alone", { x: 200, y: 200 }, 10, [], camera);
  expect(written(labels)).toEqual([{ text: "alone", x: 200, y: 177 }]);
  labels.add(ctx, "second", { x: 200, y: 200 }, 10, [], camera);
  const [one, other] = written(labels);
  expect(Math.abs(one.y - other.y)).toBeGreaterThan(17);
  labels.clear();
  labels.add(ctx, "beside a piece", { x: 200, y: 200 }, 10, [token(200, 178)], camera);
  expect(Math.abs(written(labels)[0].y - 178)).toBeGreaterThan(19);
  labels.clear();
  labels.free = [190, 0];
  labels.add(ctx, "below buttons", { x: 200, y: 200 }, 10, [], camera);
  expect(written(labels)[0].y).toBeGreaterThan(200);
});
