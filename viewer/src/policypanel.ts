// The panel of the policy: what the picked piece could do, and what its player thought of it.

import { badge, facts, make } from "./dom";
import { isCellName, parseCell } from "./hex";
import { signed, spoken } from "./log";
import type { Scene } from "./scene";
import type { Game, Piece } from "./state";
import { CAMPS, type Choice } from "./story";

export interface Decision {
  tick: number;
  choice: Choice;
  tasks: string[];
}

/** What a piece decided last. */
export function decisionOf(game: Game, piece: Piece, tick: number): Decision | null {
  const policy = game.story.policy[piece.camp];
  const made = policy?.decisions.filter(([at]) => at <= tick) ?? [];
  for (let k = made.length - 1; policy && k >= 0; k--) {
    const choice = made[k][1].find(([index]) => index === piece.index);
    if (choice) return { tick: made[k][0], choice, tasks: policy.tasks };
  }
  return null;
}

/** Ticks at which a piece chose another task than before. */
export function mindsOf(game: Game, piece: Piece | null): number[] {
  const policy = piece ? game.story.policy[piece.camp] : undefined;
  const found: number[] = [];
  let before = -1;
  for (const [tick, choices] of policy?.decisions ?? []) {
    const choice = choices.find(([index]) => index === piece?.index);
    const task = choice ? choice[2][choice[1]] : before;
    if (before >= 0 && task !== before) found.push(tick);
    before = task;
  }
  return found;
}

/** The cell that a task's text names, -1 where it names none. */
export function taskCell(game: Game, text: string): number {
  const name = text.split(" ").find(isCellName);
  if (name) return parseCell(game.map, name);
  const target = text.split(" ").find((word) => word.includes(":"));
  const piece = target ? game.byName(target) : undefined;
  return piece ? -2 - piece.index : -1;
}

export function policyPanel(panel: HTMLElement, scene: Scene): void {
  const decision = scene.picked ? decisionOf(scene.game, scene.picked, scene.state.tick) : null;
  const key = `policy ${scene.game.view} ${scene.picked?.index} ${decision?.tick}`;
  if (panel.dataset.key === key) return;
  panel.dataset.key = key;
  const known = CAMPS.filter((camp) => scene.game.story.policy[camp]);
  if (known.length === 0) {
    panel.replaceChildren(make("p", { class: "soft" }, "This replay has no policy layer: it was recorded without what its players thought."));
  } else if (!scene.picked || !decision) {
    panel.replaceChildren(make("p", { class: "soft" }, `Pick a piece of ${known.join(" or ")} to see its tasks and their values.`));
  } else {
    panel.replaceChildren(...taskList(scene.picked, decision), ...reward(scene, scene.picked));
  }
}

function taskList(piece: Piece, decision: Decision): HTMLElement[] {
  const [, chosen, tasks, q, way] = decision.choice;
  const base = q[chosen] ?? 0;
  const most = Math.max(1, ...q.map((value) => Math.abs(value - base)));
  const order = tasks.map((_, k) => k).sort((a, b) => (q[b] ?? 0) - (q[a] ?? 0));
  const list = make("ol", { class: "tasks" });
  for (const k of order) {
    const bar = make("span", { class: "bar", "aria-hidden": "true" });
    if (q.length) bar.append(piecePart((q[k] - base) / most));
    const value = q.length ? (q[k] / 1000).toFixed(3).replace("-", "−") : "";
    list.append(make("li", { class: k === chosen ? "chosen" : "" }, make("span", {}, decision.tasks[tasks[k]]), bar, make("span", { class: "q" }, value)));
  }
  const second = order.find((k) => k !== chosen);
  const gap = q.length && second !== undefined ? `${((base - q[second]) / 1000).toFixed(3)} before the next` : "";
  const head = make("h2", {}, badge(piece.camp, piece.letter), `${spoken(piece.name)} at tick ${decision.tick}`);
  const rows = facts([["chose", decision.tasks[tasks[chosen]] ?? ""], ["gap", gap], ["led", way ? `the lower level went ${way}` : ""]]);
  const note = q.length
    ? "Q is what it expected of the team by the paper's mixer, not of the piece, in its learner's units: by default 1 is 50 points. Bars are around the chosen task."
    : "A scripted player has no values; this is its plan as a task.";
  return [head, rows, list, make("p", { class: "small soft" }, note)];
}

function piecePart(share: number): HTMLElement {
  const part = make("i");
  part.style.left = `${share < 0 ? 50 + share * 50 : 50}%`;
  part.style.width = `${Math.max(1.5, Math.abs(share) * 50)}%`;
  return part;
}

function reward(scene: Scene, piece: Piece): HTMLElement[] {
  const rows = scene.game.story.rewards?.filter(([tick, camp]) => camp === piece.camp && tick <= scene.state.tick) ?? [];
  const last = rows[rows.length - 1];
  if (!last) return [];
  const parts = Object.entries(last[2]).map(([term, value]): [string, string] => [term, signed(value)]);
  return [make("h3", {}, `Reward since its last decision, tick ${last[0]}`), facts(parts)];
}
