import { expect, test, vi } from "vitest";
import { readMap } from "../src/hex";
import { readTyped } from "../src/play/command";
import { stepped } from "../src/play/cursor";
import { actOf } from "../src/play/hands";
import { Lookup } from "../src/play/lookup";
import { cellsOf, classes, endOf, sayChances, sayOrder, stepOf } from "../src/play/orders";
import type { Play } from "../src/play/play";
import { type Change, type HelloDoc, type NowDoc, changed } from "../src/play/protocol";
import { Session } from "../src/play/session";
import { Refused, Wire } from "../src/play/wire";
import { Game } from "../src/state";
import type { StoryDoc } from "../src/story";

const mapDoc = {
  name: "small", width: 5, height: 3, grade_m: 10,
  terrain: [".f.f.", ".==.", "....."], levels: ["0 1 2 1 0", "0 0 0 0", "0 0 0 0 0"],
};
const map = readMap(mapDoc);

function story(): StoryDoc {
  return {
    format: "hexwar-story", version: 1, view: "red", scenario: "small", map: "", game_ticks: 100, net_score: false, last: 0,
    players: { red: { name: "Ann", kind: "human" }, blue: { name: "MA2", kind: "bot" } }, roster: [["red:tank0", "tank"], ["blue:tank0", "tank"]], points: [["ford", 7, 80]],
    rules: { version: "1", air_height_m: 200, hidden_sight_divisor: 2, concealed_sight_divisor: 2, kinds: { tank: { value: 10, blood: 3, hop_ticks: 20, sight: { tank: 25, soldier: 10 }, weapons: [["GUN", 18, 10, 0]] } } },
    pieces: { "red:tank0": { cell: [0, 0], blood: [0, 3], hops: [] } }, beliefs: { red: { "blue:tank0": { state: [0, 0] } } },
    owners: [[0, "green"]], known_margin: { red: [0, -80] }, own_total: {}, fights: [0, []], bursts: [0, []], rounds: [], events: [], orders: [], policy: {},
  };
}

const state = {
  clock: { tick: 0, end: 100, running: false, speed: 8, over: false }, stops: { first_sight: true, own_loss: true, idle: true },
  tray: {}, plans: {}, undo: 0, hints: { policy: null, used: 0 },
};

function hello(): HelloDoc {
  return { say: "hello", version: 1, role: "commands", camp: "red", name: "evening", opponent: "MA2", scenario: "small", map: mapDoc, story: story(), ...structuredClone(state), ladder: null, over: null };
}

function now(more: Partial<NowDoc>): NowDoc {
  return { say: "now", story: {}, ...structuredClone(state), stopped: null, refused: [], ...more };
}

// --- the story ------------------------------------------------------------------------------------

test("a change names what it sets, what it appends and what is gone, and leaves the old value as it was", () => {
  const before = { last: 0, pieces: { a: { hops: [[0, 20, 1]], blood: [0, 3] } }, events: [1, 2, 3] };
  const change: Change = { last: ["=", 8], pieces: { a: { hops: ["+", 1, [[20, 40, 2]]] }, b: ["=", { blood: [0, 1] }] }, events: ["+", 1, [9]] };
  expect(changed(before, change)).toEqual({ last: 8, pieces: { a: { hops: [[0, 20, 1], [20, 40, 2]], blood: [0, 3] }, b: { blood: [0, 1] } }, events: [1, 9] });
  expect(before.pieces.a.hops).toHaveLength(1);
  expect(changed(before, {})).toEqual(before);
  expect(changed({ a: 1, b: 2 }, { a: ["-"] })).toEqual({ b: 2 });
  expect(changed({ a: 1 }, { a: ["=", ["+", "-"]] })).toEqual({ a: ["+", "-"] }); // a value is never read as a change
  expect(changed({} as Record<string, unknown>, { new: { list: ["+", 0, [1]] } })).toEqual({ new: { list: [1] } });
});

test("what the server says by itself is drawn: a piece moves, an enemy is seen, the clock stands and says why", () => {
  const session = new Session(hello());
  session.take(now({
    story: { last: ["=", 20], pieces: { "red:tank0": { hops: ["+", 0, [[0, 20, 1]]] } }, beliefs: { red: { "blue:tank0": { state: ["+", 2, [20, 1]], cell: ["=", [20, 4]], blood: ["=", [20, 3]] } } } },
    clock: { ...state.clock, tick: 20 }, stopped: "blue:tank0 came into sight in 0501",
  }));
  expect(session.game.at(20).pieces.map((one) => [one.cell, one.how])).toEqual([[1, "own"], [4, "seen"]]);
  expect(session.game.at(10).pieces[0].at.x).toBeGreaterThan(session.game.at(0).pieces[0].at.x);
  expect([session.stopped, session.stoppedAt]).toEqual(["blue:tank0 came into sight in 0501", 4]);
  expect(session.entries.map((one) => one.text)).toEqual(["red sees blue tank0 in 0501"]);
  session.take(now({ clock: { ...state.clock, tick: 20, running: true } }));
  expect([session.stopped, session.stoppedAt]).toEqual([null, -1]);
  session.take(now({ clock: { ...state.clock, tick: 20 }, stopped: "tank0 lost 1, 2 left" }));
  expect(session.stoppedAt).toBe(1);
});

test("a piece is idle until somebody tells it what to do", () => {
  const session = new Session(hello());
  expect(session.isIdle("tank0")).toBe(true);
  session.take(now({ tray: { tank0: "tank0 hide" } }));
  expect([session.isIdle("tank0"), session.waiting]).toEqual([false, 1]);
  session.take(now({ plans: { tank0: ["tank0 go 0301"] } }));
  expect([session.isIdle("tank0"), session.waiting]).toEqual([false, 0]);
});

test("a hint is shown as what a policy decided, and counted", () => {
  const session = new Session(hello());
  session.takeHint({ piece: "tank0", chosen: 1, tasks: ["stop", "hold 0301"], values: [-40, 655], used: 1 });
  expect(session.game.story.policy.red).toEqual({ tasks: ["stop", "hold 0301"], decisions: [[0, [[0, 1, [0, 1], [-40, 655], ""]]]] });
  session.take(now({ story: { last: ["=", 1] } }));
  expect(session.game.story.policy.red?.decisions).toHaveLength(1);
});

// --- the wire -------------------------------------------------------------------------------------

test("an answer and a refusal find who has asked, the rest goes to the page", async () => {
  const sent: { id: number; ask: string }[] = [];
  const heard = vi.fn();
  const wire = new Wire({ send: (text) => sent.push(JSON.parse(text)) }, heard);
  const [path, plan] = [wire.ask("path", { piece: "tank0", to: 4, from: null }), wire.ask("plan", { piece: "tank0", steps: ["tank0 hide"], then: false })];
  expect(sent[0]).toEqual({ id: 1, ask: "path", piece: "tank0", to: 4, from: null });
  wire.take(JSON.stringify({ say: "refusal", to: 2, why: "red tank0 is hidden already" }));
  wire.take(JSON.stringify({ say: "answer", to: 1, cells: [1, 2] }));
  wire.take(JSON.stringify(now({})));
  await expect(plan).rejects.toThrow(new Refused("red tank0 is hidden already"));
  expect(await path).toMatchObject({ cells: [1, 2] });
  expect(heard).toHaveBeenCalledOnce();
});

test("a closed socket answers nobody, and questions of the pointer stay below the server's limit", async () => {
  const wire = new Wire({ send: () => {} }, () => {});
  const asked = wire.wonder("look", { piece: "tank0", at: null }, 0);
  wire.close();
  await expect(asked).rejects.toThrow("the connection was lost");
  let count = 1;
  while (wire.hasRoom(100)) {
    void wire.wonder("look", {}, 100).catch(() => {});
    count += 1;
  }
  expect(count).toBe(25);
  expect(wire.hasRoom(1200)).toBe(true);
});

test("a place is asked for once, the old answer stands while a new one is under way", async () => {
  const sent: { id: number }[] = [];
  const wire = new Wire({ send: (text) => sent.push(JSON.parse(text)) }, () => {});
  const news = vi.fn();
  const paths = new Lookup("path", news);
  const get = (version: number) => paths.get(wire, "tank0 4", { piece: "tank0", to: 4, from: null }, version);
  expect([get(0), get(0)]).toEqual([undefined, undefined]);
  expect(sent).toHaveLength(1);
  wire.take(JSON.stringify({ say: "answer", to: sent[0].id, arrives: 40 }));
  await vi.waitFor(() => expect(news).toHaveBeenCalledOnce());
  expect([get(0), get(1)]).toMatchObject([{ arrives: 40 }, { arrives: 40 }]);
  await paths.need(wire, "tank0 4", {}, 0);
  expect(sent).toHaveLength(1);
});

// --- orders ---------------------------------------------------------------------------------------

test("orders are said in words", () => {
  expect(sayOrder("tank0 shoot blue:tank0 GUN")).toBe("Shoot at blue tank0 with GUN");
  expect(sayOrder("soldier0 guide-shoot blue:tank0 chariot0")).toBe("Guide a missile to blue tank0 from chariot0");
  expect(sayOrder("tank0 move 0201 0301")).toBe("Move to 0301");
  expect(sayOrder("chariot0 get-off soldier0")).toBe("Set down soldier0");
  expect(sayOrder("tank0 hide")).toBe("Hide");
});

test("a move leads over cells and directions, a plan ends in its last waypoint", () => {
  expect(cellsOf(map, 0, "tank0 move 0201 0301")).toEqual([1, 2]);
  expect(cellsOf(map, 0, "tank0 move E SE")).toEqual([1, 6]);
  expect(cellsOf(map, 0, "tank0 hide")).toEqual([]);
  expect(endOf(map, 0, "tank0 move 0201", ["tank0 hide"])).toBe(1);
  expect(endOf(map, 0, "tank0 move 0201", ["tank0 go 0401", "tank0 hide"])).toBe(3);
  expect(endOf(map, 0, undefined, [])).toBe(0);
});

test("a move to one cell is a way there", () => {
  expect(stepOf("tank0 move 1234")).toBe("tank0 go 1234");
  expect(stepOf("tank0 move 1234 1235")).toBe("tank0 move 1234 1235");
  expect(stepOf("tank0 MOVE E")).toBe("tank0 move E");
});

test("chances are told in five classes", () => {
  expect(classes([0.2, 0.3, 0.1, 0.1, 0.2, 0.1])).toEqual([0.2, 0.3, 0.1, 0.1, expect.closeTo(0.3)]);
  expect(sayChances([0.5, 0.25, 0.25])).toBe("nothing 50\u00a0%, suppressed 25\u00a0%, 1 lost 25\u00a0%");
});

// --- hands ----------------------------------------------------------------------------------------

test("arrows reach every cell, and stop at the edge of the map", () => {
  const go = (cell: number, ...keys: string[]) => keys.reduce((here, key) => stepped(map, here, key, false), cell);
  expect([go(0, "ArrowRight"), go(0, "ArrowDown"), go(0, "ArrowLeft"), go(0, "ArrowUp")]).toEqual([1, 5, 0, 0]);
  expect(go(4, "ArrowDown")).toBe(8); // odd rows are one cell shorter
  expect(stepped(map, 0, "ArrowRight", true)).toBe(4);
  const reached = new Set([0]);
  for (const cell of reached) for (const key of ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"]) reached.add(go(cell, key));
  expect(reached.size).toBe(14);
});

test("the line knows orders, pieces, cells and the clock", () => {
  const game = new Game(story(), map);
  const read = (text: string) => readTyped(text, game, map, "red");
  expect(read("tank0 move 0301")).toEqual({ kind: "order", text: "tank0 move 0301", then: false });
  expect(read("/then tank0 shoot blue:tank0 GUN")).toEqual({ kind: "order", text: "tank0 shoot blue:tank0 GUN", then: true });
  expect(read("tank0")).toMatchObject({ kind: "pick", piece: { name: "red:tank0" } });
  expect(read("blue:tank0")).toMatchObject({ kind: "pick", piece: { name: "blue:tank0" } });
  expect(read("0301")).toEqual({ kind: "cell", cell: 2 });
  expect([read("go"), read("undo"), read("next"), read("?")].map(({ kind }) => kind)).toEqual(["go", "undo", "next", "help"]);
  expect(read("speed 16")).toEqual({ kind: "speed", speed: 16 });
  expect(read("speed 7").kind).toBe("unknown");
  expect(read("tank9 hide").kind).toBe("unknown");
});

/** A page that only notes what is asked of it. */
function page(more: object = {}) {
  return { cursor: -1, place: "now", canOrder: true, picked: null, session: { state: { clock: { running: false } }, map }, run: vi.fn(), undo: vi.fn(), plan: vi.fn(), planAt: vi.fn(), step: vi.fn(), toggleClock: vi.fn(), ...more };
}

function press(play: object, key: string, shiftKey = false): void {
  actOf(play as Play, { key, shiftKey } as KeyboardEvent)?.();
}

test("Enter plans at the cursor, with shift after what is planned; without a cursor it starts the clock", () => {
  const aiming = page({ cursor: 3 });
  press(aiming, "Enter");
  press(aiming, "Enter", true);
  expect(aiming.planAt.mock.calls).toEqual([[3, false], [3, true]]);
  expect(aiming.run).not.toHaveBeenCalled();
  const ready = page();
  press(ready, "Enter");
  expect(ready.run).toHaveBeenCalledOnce();
  const running = page({ session: { state: { clock: { running: true } }, map } });
  press(running, "Enter");
  expect(running.run).not.toHaveBeenCalled();
});

test("keys give orders to the picked piece, and take them back", () => {
  const play = page({ picked: { short: "tank0", own: {} } });
  for (const key of ["h", "o", "s", "Backspace", ".", "n", "d", " "]) press(play, key);
  expect(play.plan.mock.calls).toEqual([[["tank0 hide"], false], [["tank0 occupy"], false], [["tank0 stop"], false]]);
  expect(play.step.mock.calls).toEqual([["tick"], ["event"], ["decision"]]);
  expect(play.undo).toHaveBeenCalledOnce();
  expect(play.toggleClock).toHaveBeenCalledOnce();
  const nobody = page();
  press(nobody, "h");
  expect(nobody.plan).not.toHaveBeenCalled();
});
