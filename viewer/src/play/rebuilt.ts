// A part of the page that is made anew when its key has changed; who has the focus keeps it.

export function rebuilt(part: HTMLElement, key: string, build: () => (Node | string)[]): void {
  if (part.dataset.key === key) return;
  part.dataset.key = key;
  const focused = part.contains(document.activeElement) ? (document.activeElement as HTMLElement).id : "";
  const { scrollTop } = part;
  part.replaceChildren(...build());
  part.scrollTop = scrollTop;
  if (focused) document.getElementById(focused)?.focus();
}
