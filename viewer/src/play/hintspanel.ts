// The panel of hints: what a policy would do, on request, and counted. The list is the viewer's panel of the policy.

import { make, say } from "../dom";
import { decisionOf, policyPanel } from "../policypanel";
import type { Scene } from "../scene";
import type { Play } from "./play";

export function hintsPanel(panel: HTMLElement, play: Play, scene: Scene): void {
  const { hints } = play.session.state;
  const key = `hints ${play.session.camp} ${hints.policy}`;
  if (panel.dataset.key !== key) {
    panel.dataset.key = key;
    panel.replaceChildren(...build(play));
  }
  const ask = panel.querySelector<HTMLButtonElement>("#hint");
  const list = panel.querySelector<HTMLElement>("#hint-list");
  if (!ask || !list) return;
  ask.disabled = !play.canOrder;
  say(ask, play.picked?.own ? `Ask what ${hints.policy} would do with ${play.picked.short}` : "Pick a piece of yours first");
  say(panel.querySelector("#hints-used") as HTMLElement, `${hints.used} ${hints.used === 1 ? "hint" : "hints"} so far. They are counted, and stand in the replay.`);
  const hinted = scene.picked && decisionOf(scene.game, scene.picked, scene.state.tick);
  list.hidden = !hinted;
  if (hinted) policyPanel(list, scene);
}

function build(play: Play): HTMLElement[] {
  if (!play.session.state.hints.policy) return [make("p", { class: "soft" }, "This game has no policy for hints. `hexwar play --hints RUN` begins one with hints.")];
  const ask = make("button", { type: "button", id: "hint", class: "strong" });
  ask.addEventListener("click", () => void play.hint());
  return [ask, make("p", { id: "hints-used", class: "small soft" }), make("div", { id: "hint-list" })];
}
