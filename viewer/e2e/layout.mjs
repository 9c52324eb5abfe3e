// What lies over what on a page: runs in the browser. Texts of the page and of its canvases, tokens and buttons.

/** Before the page's own script: each canvas remembers the texts that it shows. */
export function remember() {
  const shown = new WeakMap(); // texts of a canvas, in its own pixels
  const textsOf = (canvas) => shown.get(canvas) ?? shown.set(canvas, []).get(canvas);
  const context = CanvasRenderingContext2D.prototype;
  const { fillText, clearRect, drawImage } = context;
  context.fillText = function (text, x, y, ...rest) {
    const { a, d, e, f } = this.getTransform();
    const width = this.measureText(text).width * a;
    const onPlate = this.font.startsWith("600");
    const height = Number.parseFloat(/([\d.]+)px/.exec(this.font)[1]) * d * (onPlate ? 1.3 : 0.72); // of the plate, of capitals and digits
    const left = x * a + e - (this.textAlign === "center" ? width / 2 : this.textAlign === "right" ? width : 0);
    const middle = y * d + f - (this.textBaseline === "middle" ? 0 : height / 2);
    textsOf(this.canvas).push({ text, left, top: middle - height / 2, right: left + width, bottom: middle + height / 2 });
    return fillText.call(this, text, x, y, ...rest);
  };
  context.clearRect = function (x, y, width, height) {
    if (width * this.getTransform().a >= this.canvas.width) shown.set(this.canvas, []);
    return clearRect.call(this, x, y, width, height);
  };
  context.drawImage = function (source, ...rest) {
    if (rest.length === 2 && shown.has(source)) textsOf(this.canvas).push(...shown.get(source));
    return drawImage.call(this, source, ...rest);
  };
  window.canvasTexts = (canvas) => textsOf(canvas);
}

/** What overlaps or is cut, in words; nothing where all is well. */
export function faults() {
  const LEAST = 2; // pixels
  const found = [];
  const boxOf = ({ left, top, right, bottom }) => ({ left, top, right, bottom });
  const screen = { left: 0, top: 0, right: innerWidth, bottom: innerHeight };
  const meet = (a, b) => ({ left: Math.max(a.left, b.left), top: Math.max(a.top, b.top), right: Math.min(a.right, b.right), bottom: Math.min(a.bottom, b.bottom) });
  const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > LEAST && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > LEAST;
  const outside = (a, b) => a.left < b.left - LEAST || a.right > b.right + LEAST || a.top < b.top - LEAST || a.bottom > b.bottom + LEAST;
  const name = (element) => (element.id ? `#${element.id}` : `${element.localName}.${element.className}`);

  /** What is left of a text after everything around it has been scrolled; and whether it is cut by what does not scroll. */
  function seen(box, element) {
    let cut = false;
    for (let around = element; around; around = around.parentElement) {
      const style = getComputedStyle(around);
      const edge = boxOf(around.getBoundingClientRect());
      if (style.position === "fixed") break;
      if (style.overflowX === "visible" && style.overflowY === "visible") continue;
      const scrolls = [style.overflowX, style.overflowY].some((how) => how === "auto" || how === "scroll");
      if (!scrolls && outside(box, edge)) cut = true;
      box = meet(box, edge);
    }
    if (outside(box, screen)) cut = true;
    return { box: meet(box, screen), cut };
  }

  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const { currentNode: node } = walker;
    const element = node.parentElement;
    if (!node.data.trim() || /^(script|style)$/i.test(element.localName) || element.closest("#live, .unseen, svg title, [aria-hidden=true]:not(#last)") || !element.checkVisibility({ visibilityProperty: true })) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const line of range.getClientRects()) {
      if (line.width < 1) continue;
      const height = line.height * 0.2; // letters are less high than their lines
      const { box, cut } = seen({ ...boxOf(line), top: line.top + height, bottom: line.bottom - height }, element);
      if (cut) found.push(`cut: "${node.data.trim().slice(0, 40)}" in ${name(element)}`);
      if (box.right - box.left > LEAST && box.bottom - box.top > LEAST) texts.push({ node, element, box, text: node.data.trim() });
    }
  }
  texts.forEach((one, k) => {
    for (const other of texts.slice(k + 1)) if (other.node !== one.node && overlap(one.box, other.box)) found.push(`"${one.text}" in ${name(one.element)} lies over "${other.text}" in ${name(other.element)}`);
    const top = document.elementFromPoint((one.box.left + one.box.right) / 2, (one.box.top + one.box.bottom) / 2);
    if (top && !top.contains(one.element) && !one.element.contains(top) && getComputedStyle(one.element.closest("#last") ?? one.element).pointerEvents !== "none") found.push(`${name(top)} lies over "${one.text}" in ${name(one.element)}`);
  });

  const overlays = [...document.querySelectorAll("#layers button, #zoom button, #last, #readout")].filter((one) => one.checkVisibility()).map((one) => ({ name: name(one), box: boxOf(one.getBoundingClientRect()) }));
  const stages = [...document.querySelectorAll("canvas#pieces, canvas#pieces-2")].filter((canvas) => canvas.clientWidth > 0);
  const tokens = window.hexwar.tokens();
  stages.forEach((canvas, k) => {
    const { left, top } = canvas.getBoundingClientRect();
    const placed = tokens[k].map(({ name, x, y, size }) => ({ name, x, y, size, box: { left: left + x - size, top: top + y - size, right: left + x + size, bottom: top + y + size } }));
    const edge = boxOf(canvas.getBoundingClientRect());
    placed.forEach((one, n) => {
      if (outside(one.box, edge)) found.push(`token ${one.name} is cut`);
      for (const other of placed.slice(n + 1)) if (Math.hypot(one.x - other.x, one.y - other.y) < (one.size + other.size) * 0.9) found.push(`token ${one.name} lies over ${other.name}`);
      for (const over of overlays) if (overlap(one.box, over.box)) found.push(`${over.name} lies over token ${one.name}`);
    });
    for (const { text, box } of canvasTexts(canvas)) {
      if (text.length < 2) continue;
      for (const one of placed) if (overlap(box, { ...one.box, bottom: one.box.bottom })) found.push(`"${text}" on the map lies over token ${one.name}`);
    }
  });
  const canvases = [...document.querySelectorAll("canvas")].filter((canvas) => canvas.clientWidth > 0 && canvas.checkVisibility());
  for (const canvas of canvases) {
    const edge = boxOf(canvas.getBoundingClientRect());
    const there = canvasTexts(canvas);
    there.forEach((one, k) => {
      const shown = seen(one.box, canvas);
      if (shown.cut || outside(one.box, edge)) found.push(`cut: "${one.text}" on ${name(canvas)}`);
      for (const other of there.slice(k + 1)) if (overlap(one.box, other.box)) found.push(`"${one.text}" lies over "${other.text}" on ${name(canvas)}`);
      for (const over of overlays) if (canvas.closest(".stage") && overlap(one.box, over.box)) found.push(`${over.name} lies over "${one.text}" on the map`);
    });
  }
  return [...new Set(found)];

  function canvasTexts(canvas) {
    const edge = canvas.getBoundingClientRect();
    const ratio = canvas.width / edge.width;
    return window.canvasTexts(canvas).map(({ text, ...box }) => ({ text, box: { left: edge.left + box.left / ratio, top: edge.top + box.top / ratio, right: edge.left + box.right / ratio, bottom: edge.top + box.bottom / ratio } }));
  }
}
