// What can be taken along: a picture, a film, the events. Each says who played, with which seed, under which rules.

import { byId, make, say } from "./dom";
import type { Entry } from "./log";
import type { Page } from "./page";

const CAPTION = 30; // height of the line below a picture
const FRAMES_A_SECOND = 30;
const FILMS = ["video/mp4;codecs=avc1", "video/webm;codecs=vp9", "video/webm"];

/** The layers of the map on one canvas, with a caption. */
function draw(page: Page, canvas: HTMLCanvasElement): void {
  const layers = page.stage.canvases;
  const scene = page.scene();
  const [width, height] = [layers[0].width, layers[0].height];
  const ctx = canvas.getContext("2d");
  if (!ctx) return;
  const bar = CAPTION * scene.ratio;
  [canvas.width, canvas.height] = [width - (width % 2), height + bar - ((height + bar) % 2)]; // films need even sides
  ctx.fillStyle = scene.palette.paper;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  for (const layer of layers) ctx.drawImage(layer, 0, 0);
  ctx.fillStyle = scene.palette.ink;
  ctx.font = `${13 * scene.ratio}px system-ui, sans-serif`;
  ctx.textBaseline = "middle";
  ctx.fillText(`tick ${scene.state.tick}: ${caption(page)}`, 10 * scene.ratio, height + bar / 2);
}

function caption(page: Page): string {
  const { players, scenario, seed, rules, view } = page.game.story;
  const seen = view === "referee" ? `seed ${seed}` : `as ${view} knows it`;
  return `${players.red.name} (red) against ${players.blue.name} (blue), ${scenario}, ${seen}, rules ${rules.version}`;
}

function give(blob: Blob, name: string): void {
  const link = make("a", { download: name });
  link.href = URL.createObjectURL(blob);
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function savePicture(page: Page): void {
  const canvas = document.createElement("canvas");
  draw(page, canvas);
  canvas.toBlob((blob) => blob && give(blob, `${page.game.story.scenario}-${Math.floor(page.time)}.png`));
}

/** Films from here to the end, or to where somebody stops. */
function saveFilm(page: Page): void {
  const canvas = document.createElement("canvas");
  draw(page, canvas);
  const type = FILMS.find((one) => MediaRecorder.isTypeSupported(one)) ?? "video/webm";
  const recorder = new MediaRecorder(canvas.captureStream(FRAMES_A_SECOND), { mimeType: type, videoBitsPerSecond: 6_000_000 });
  const parts: Blob[] = [];
  recorder.ondataavailable = (event) => parts.push(event.data);
  recorder.onstop = () => give(new Blob(parts, { type }), `${page.game.story.scenario}.${type.includes("mp4") ? "mp4" : "webm"}`);
  recorder.start();
  page.play(true);
  const step = () => {
    draw(page, canvas);
    if (page.playing) requestAnimationFrame(step);
    else recorder.stop();
  };
  requestAnimationFrame(step);
}

/** A value as CSV has it; a text that a spreadsheet would run is made one that it shows. */
export function csvValue(value: string | number): string {
  if (typeof value === "number") return String(value);
  const shown = /^[=+@\t-]/.test(value) ? `'${value}` : value;
  return /[",\n]/.test(shown) ? `"${shown.replaceAll('"', '""')}"` : shown;
}

export function csvOf(entries: Entry[], about: string): string {
  const rows = entries.map((one) => [one.tick, one.camp, one.shape, one.text, one.luck === null ? "" : Number(one.luck.toFixed(2))]);
  return [[about], ["tick", "camp", "kind", "text", "luck"], ...rows].map((row) => row.map(csvValue).join(",")).join("\r\n");
}

function saveEvents(page: Page): void {
  const text = csvOf(page.list().filter((one) => one.shape !== "choice"), caption(page));
  give(new Blob([text], { type: "text/csv" }), `${page.game.story.scenario}.csv`);
}

export function openSaving(page: Page): void {
  const dialog = byId<HTMLDialogElement>("saving");
  const choice = (text: string, says: string, act: (page: Page) => void) => {
    const button = make("button", { type: "button" }, text);
    button.addEventListener("click", () => {
      dialog.close();
      act(page);
    });
    return make("p", { class: "saving" }, button, make("span", { class: "soft" }, says));
  };
  const close = make("button", { type: "button" }, "Close");
  close.addEventListener("click", () => dialog.close());
  const film = "MediaRecorder" in window ? choice("Film", "plays from here and films; pause to end it", saveFilm) : null;
  dialog.replaceChildren(make("h2", {}, "Save"), choice("Picture", "of the map as it is", savePicture), film ?? "", choice("Events", "of this view, as CSV", saveEvents), close);
  dialog.showModal();
  say(byId("readout"), "");
}
