// Small helpers for the page. All text goes through textContent: nothing from a replay is ever read as markup.

export function byId<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as T;
}

type Child = Node | string | null;

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  traits: Record<string, string> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(traits)) {
    if (name === "class") element.className = value;
    else element.setAttribute(name, value);
  }
  for (const child of children) if (child !== null) element.append(child);
  return element;
}

/** Write a text only where it changed: screen readers and the layout stay quiet. */
export function say(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function press(button: HTMLElement, pressed: boolean): void {
  const value = String(pressed);
  if (button.getAttribute("aria-pressed") !== value) button.setAttribute("aria-pressed", value);
}

export function badge(camp: string, letter: string): HTMLElement {
  return make("span", { class: `badge ${camp}`, "aria-hidden": "true" }, letter);
}

export function bars(blood: number, full: number): HTMLElement {
  const row = make("span", { class: "bars", role: "img", "aria-label": `${blood} of ${full}` });
  for (let k = 0; k < full; k++) row.append(make("i", { class: k < blood ? "full" : "" }));
  return row;
}

export function facts(rows: [string, Child][]): HTMLElement {
  const list = make("dl");
  for (const [name, value] of rows) if (value !== null && value !== "") list.append(make("dt", {}, name), make("dd", {}, value));
  return list;
}
