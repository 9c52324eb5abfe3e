import { expect, test } from "vitest";
import { readMoment, writeMoment } from "../src/commands";
import { changesPart, partingOf } from "../src/compare";
import { type EntryDoc, resultOf, whyApart } from "../src/contents";
import { tint } from "../src/cover";
import { unwoven } from "../src/packed";
import type { StoryDoc } from "../src/story";
import { short, ticksOf } from "../src/svg";

const entry: EntryDoc = {
  name: "one", players: { red: { name: "Ann", kind: "human" }, blue: { name: "Ben", kind: "bot" } }, scenario: "small", map: "m", setup: "s", rules: "r",
  views: ["referee", "red", "blue"], last: 100, margin: { red: 10, blue: -10 }, owners: ["red"], tokens: [[0, 3]], seed: "7", winner: "red",
};

function story(more: Partial<StoryDoc>): StoryDoc {
  return { seed: "7", orders: [], events: [], pieces: {}, ...more } as StoryDoc;
}

test("differences are added up again, and views are parted", () => {
  const woven = {
    view: { red: "red" },
    pieces: { red: { "red:tank0": { hops: [[0, 20, 78], [5, 20, 1], [0, 20, 1, 5]], blood: [0, 3, 20, 2], cool_ends: [10, 75, 75, 0] } }, blue: {} },
    beliefs: { red: { red: { "blue:tank0": { cell: [10, 4, 20, 1], state: [10, 1] } } } },
    events: { red: [{ tick: 5, kind: "shot" }, { tick: 0, kind: "loss" }, { tick: 7, kind: "shot" }] },
    orders: { red: [[3, "red", [], []], [75, "red", [], []]] },
  };
  const found = unwoven(woven as never, "red", { scenario: "small" });
  expect(found.scenario).toBe("small");
  expect(found.pieces["red:tank0"]).toEqual({ hops: [[0, 20, 78], [25, 45, 79], [45, 65, 80, 50]], blood: [0, 3, 20, 2], cool_ends: [10, 85, 85, 0] });
  expect(found.beliefs.red?.["blue:tank0"]).toEqual({ cell: [10, 4, 30, 5], state: [10, 1] });
  expect(found.events.map((one) => one.tick)).toEqual([5, 5, 12]);
  expect(found.orders.map((one) => one[0])).toEqual([3, 78]);
});

test("games can be compared on one map, in one scenario, by the same rules", () => {
  expect(whyApart(entry, { ...entry })).toBeNull();
  expect(whyApart(entry, entry)).toBe("the same game");
  expect(whyApart(entry, { ...entry, map: "n", setup: "t" })).toBe("another map");
  expect(whyApart(entry, { ...entry, setup: "t" })).toBe("another scenario");
  expect(whyApart(entry, { ...entry, rules: "t" })).toBe("other rules");
});

test("two games of one seed part at the first order, piece or event that differs", () => {
  const order = (tick: number, camp: string, text: string) => [tick, camp, [text], []] as never;
  const a = story({ orders: [order(0, "red", "tank0 stop"), order(75, "blue", "tank0 hide")], events: [{ tick: 90, kind: "shot", piece: "red:tank0" }] });
  const b = story({ orders: [order(0, "red", "tank0 stop"), order(75, "blue", "tank0 stop")], events: [{ tick: 80, kind: "shot", piece: "red:tank0" }] });
  expect(partingOf(a, b)).toEqual({ tick: 75, orders: { blue: 75 } });
  expect(partingOf(a, story({ ...b, orders: a.orders }))).toEqual({ tick: 80, orders: {} });
  expect(partingOf(a, a)).toBeNull();
  expect(partingOf(a, { ...b, seed: "8" })).toBeNull();
  expect(partingOf({ ...a, seed: undefined } as never, { ...b, seed: undefined } as never)).toBeNull();
  const piece = (blood: number[], hops: number[][]) => story({ pieces: { "red:tank0": { blood, hops } } });
  expect(partingOf(piece([0, 3, 50, 2], []), piece([0, 3, 50, 1], []))?.tick).toBe(50);
  expect(partingOf(piece([0, 3], [[0, 20, 1]]), piece([0, 3], [[10, 30, 1]]))?.tick).toBe(0);
});

test("changes part where one of them has another value, or has one earlier", () => {
  expect(changesPart([0, 1, 10, 2], [0, 1, 12, 2])).toBe(10);
  expect(changesPart([0, 1], [0, 1, 30, 2])).toBe(30);
  expect(changesPart([0, [1]], [0, [1]])).toBe(Number.POSITIVE_INFINITY);
});

test("the address names the game, and the one beside it", () => {
  expect(writeMoment({ game: 3, t: 577 })).toBe("#game=3&t=577");
  expect(readMoment("#game=3&with=5&t=577")).toEqual({ game: 3, with: 5, t: 577 });
  expect(readMoment("#game=0&with=1.5")).toEqual({});
  expect(readMoment("#game=-1")).toEqual({});
});

test("results, steps, axes and colours read well", () => {
  expect([resultOf(entry), resultOf({ ...entry, winner: "draw" }), resultOf({ ...entry, winner: null })]).toEqual(["red wins", "a draw", ""]);
  expect([short(0), short(500), short(48000), short(1_250_000)]).toEqual(["0", "500", "48k", "1.25M"]);
  expect(ticksOf(0, 1, 4)).toEqual([0, 0.25, 0.5, 0.75, 1]);
  expect(ticksOf(-136, 166, 4)).toEqual([-100, 0, 100]);
  expect([tint(1, false), tint(0.5, false), tint(0, false)]).toEqual(["rgb(236,164,152)", "rgb(246,245,242)", "rgb(158,191,236)"]);
});
