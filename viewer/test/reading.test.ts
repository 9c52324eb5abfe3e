import { expect, test } from "vitest";
import { readCommand, readMoment, writeMoment } from "../src/commands";
import { apart, cellAt, cellName, centre, neighbour, parseCell, readMap } from "../src/hex";
import { entriesOf, luckOf } from "../src/log";
import { Game } from "../src/state";
import { csvOf, csvValue } from "../src/save";
import { type StoryDoc, valueAt } from "../src/story";

const map = readMap({
  name: "small", width: 5, height: 3, grade_m: 10,
  terrain: [".f.f.", ".==.", "....."], levels: ["0 1 2 1 0", "0 0 0 0", "0 0 0 0 0"],
});

const story: StoryDoc = {
  format: "hexwar-story", version: 1, view: "referee", scenario: "small", map: "", game_ticks: 100, net_score: false, last: 100,
  players: { red: { name: "<b>Ann</b>", kind: "human" }, blue: { name: "Ben", kind: "bot" } },
  roster: [["red:tank0", "tank"], ["blue:tank0", "tank"]],
  points: [["ford", 7, 80]],
  rules: { version: "1", air_height_m: 200, hidden_sight_divisor: 2, concealed_sight_divisor: 2, kinds: { tank: { value: 10, blood: 3, hop_ticks: 20, sight: { tank: 25, soldier: 10 }, weapons: [["GUN", 18, 10, 0]] } } },
  pieces: {
    "red:tank0": { cell: [0, 0], blood: [0, 3], hops: [[0, 20, 1], [20, 40, 2, 30]], sees: [10, [1]] },
    "blue:tank0": { cell: [0, 4], blood: [0, 3, 25, 1], hops: [] },
  },
  beliefs: { red: { "blue:tank0": { state: [0, 0, 10, 1, 50, 2], cell: [10, 4], blood: [10, 3, 25, 1], last: [50, 49] } }, blue: { "red:tank0": { state: [0, 0] } } },
  owners: [[0, "green", 60, "red"]], margin: { red: [0, -80, 60, 80], blue: [0, -80] },
  known_margin: { red: [0, -80], blue: [0, -80] }, own_total: {}, fights: [0, []], bursts: [0, []], rounds: [], policy: {},
  events: [
    { tick: 25, kind: "shot", piece: "red:tank0", target: "blue:tank0", cell: "0501", weapon: "GUN", level: 9, cells_apart: 3, roll: 7, modifiers: -2, result: 2, expected: 7.4, variance: 50, lost: 20, chances: [] },
    { tick: 25, kind: "loss", piece: "blue:tank0", losses: 2 },
    { tick: 25, kind: "suppressed", piece: "blue:tank0" },
  ],
  orders: [[30, "red", ["tank0 stop"], [["tank0 occupy", "red tank0 is moving"]]]],
};

test("a cell has one name and one place", () => {
  for (const cell of [0, 4, 5, 8, 14]) {
    expect(parseCell(map, cellName(map, cell))).toBe(cell);
    expect(cellAt(map, centre(map, cell))).toBe(cell);
  }
  expect(parseCell(map, "0502")).toBe(-1); // odd rows are one cell shorter
  expect(parseCell(map, "05")).toBe(-1);
  expect(neighbour(map, 0, 3)).toBe(1);
  expect(apart(map, 0, 14)).toBe(5);
});

test("a value holds from its tick to the next", () => {
  const list = [0, "a", 10, "b"];
  expect([-1, 0, 9, 10, 99].map((tick) => valueAt(list, tick, "none"))).toEqual(["none", "a", "a", "b", "b"]);
  expect(valueAt(undefined, 5, 7)).toBe(7);
});

test("a piece goes with its hops, and stays where one was broken off", () => {
  const game = new Game(story, map);
  const at = (time: number) => game.at(time).pieces[0];
  expect([at(0).cell, at(19).cell, at(20).cell, at(35).cell]).toEqual([0, 0, 1, 1]);
  expect(at(10).at.x).toBeCloseTo((centre(map, 0).x + centre(map, 1).x) / 2);
  expect(at(31).at).toEqual(centre(map, 1));
});

test("a piece that is out of sight is where it was last seen, and ages", () => {
  const ghost = new Game(story, map).ghosts("red", 70);
  expect(ghost.map((one) => [one.piece.name, one.cell, one.blood, one.age])).toEqual([["blue:tank0", 4, 1, 21]]);
  expect(new Game(story, map).ghosts("blue", 70)).toEqual([]);
});

test("a shot is one line, with its dice and its luck", () => {
  const fire = entriesOf(new Game(story, map)).filter((one) => one.group === "fire" && one.shape !== "point");
  expect(fire.map((one) => one.text)).toEqual(["red tank0 GUN → blue tank0, 3 cells: expected 7.4, 2d6 = 7 (level 9, −2), lost 2 = 20 points"]);
  expect(fire[0].luck).toBeCloseTo(12.6);
  expect(luckOf(new Game(story, map), "red")).toEqual({ ticks: [0, 25], sum: [0, 20 - 7.4], sigma: [0, Math.sqrt(50)] });
});

test("sightings, captures and refusals are entries", () => {
  const texts = entriesOf(new Game(story, map)).map((one) => `${one.tick} ${one.shape} ${one.text}`);
  expect(texts).toContain("10 sight red sees blue tank0 in 0501");
  expect(texts).toContain("50 lost red loses sight of blue tank0");
  expect(texts).toContain("60 point red takes ford (80 points)");
  expect(texts).toContain("30 refused red tank0 occupy: refused, red tank0 is moving");
});

test("the address of a moment comes back", () => {
  const moment = { t: 577, view: "red" as const, pick: "red:tank1", speed: 8 };
  expect(writeMoment(moment)).toBe("#t=577&view=red&pick=red:tank1&speed=8");
  expect(readMoment(writeMoment(moment))).toEqual(moment);
  expect(readMoment("#t=-4&view=green&speed=7&x=<b>")).toEqual({});
  expect(readMoment("#t=1e400")).toEqual({});
});

test("the command line knows ticks, pieces, cells, views and speeds", () => {
  const game = new Game(story, map);
  const read = (text: string, camp = "red") => readCommand(text, game, map, camp);
  expect(read("t 57")).toEqual({ kind: "seek", tick: 57 });
  expect(read("99999")).toEqual({ kind: "seek", tick: 100 });
  expect(read("0301")).toEqual({ kind: "cell", cell: 2 });
  expect(read("tank0", "blue")).toMatchObject({ kind: "pick", piece: { name: "blue:tank0" } });
  expect(read("blue tank0")).toMatchObject({ kind: "pick", piece: { name: "blue:tank0" } });
  expect(read("/speed 8")).toEqual({ kind: "speed", speed: 8 });
  expect(read("Red")).toEqual({ kind: "view", view: "red" });
  expect(read("?")).toEqual({ kind: "help" });
  expect(read("speed 7").kind).toBe("unknown");
  expect(read("").kind).toBe("unknown");
});

test("events as CSV say what they are of, and run nothing", () => {
  const lines = csvOf(entriesOf(new Game(story, map)), "=Ann against Ben").split("\r\n");
  expect(lines[0]).toBe("'=Ann against Ben");
  expect(lines[1]).toBe("tick,camp,kind,text,luck");
  expect(lines.find((line) => line.startsWith("25,red,hit"))).toBe('25,red,hit,"red tank0 GUN → blue tank0, 3 cells: expected 7.4, 2d6 = 7 (level 9, −2), lost 2 = 20 points",12.6');
  expect([csvValue('a"b'), csvValue("-1"), csvValue(-1)]).toEqual(['"a""b"', "'-1", "-1"]);
});
