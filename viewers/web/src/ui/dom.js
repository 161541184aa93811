// Small helpers to build the controls.

/** An element: h("button", {class: "x", onclick: f, "aria-label": "Play"}, "text", child). */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

const PATHS = {
  play: '<path d="M7 4.6v14.8a.7.7 0 0 0 1.07.6l11.6-7.4a.7.7 0 0 0 0-1.2L8.07 4A.7.7 0 0 0 7 4.6z" fill="currentColor" stroke="none"/>',
  pause: '<rect x="6" y="4.5" width="4" height="15" rx="1" fill="currentColor" stroke="none"/><rect x="14" y="4.5" width="4" height="15" rx="1" fill="currentColor" stroke="none"/>',
  first: '<path d="M6 5v14"/><path d="M19 5.5v13L9 12z" fill="currentColor"/>',
  last: '<path d="M18 5v14"/><path d="M5 5.5v13L15 12z" fill="currentColor"/>',
  back: '<path d="M16.5 5.5v13L7 12z" fill="currentColor"/>',
  forward: '<path d="M7.5 5.5v13L17 12z" fill="currentColor"/>',
  camera: '<path d="M4 8.5A1.5 1.5 0 0 1 5.5 7h2.2l1.4-2h5.8l1.4 2h2.2A1.5 1.5 0 0 1 20 8.5v9a1.5 1.5 0 0 1-1.5 1.5h-13A1.5 1.5 0 0 1 4 17.5z"/><circle cx="12" cy="12.7" r="3.4"/>',
  help: '<circle cx="12" cy="12" r="8.5"/><path d="M9.6 9.6a2.5 2.5 0 1 1 3.7 2.2c-.8.5-1.3 1-1.3 2"/><path d="M12 16.6v.1"/>',
  theme: '<circle cx="12" cy="12" r="8"/><path d="M12 4a8 8 0 0 1 0 16z" fill="currentColor"/>',
  frame: '<path d="M4 9V5.5A1.5 1.5 0 0 1 5.5 4H9M15 4h3.5A1.5 1.5 0 0 1 20 5.5V9M20 15v3.5a1.5 1.5 0 0 1-1.5 1.5H15M9 20H5.5A1.5 1.5 0 0 1 4 18.5V15"/><circle cx="12" cy="12" r="2.2"/>',
  follow: '<circle cx="12" cy="12" r="5.5"/><path d="M12 3v4M12 17v4M3 12h4M17 12h4"/>',
  close: '<path d="M6 6l12 12M18 6L6 18"/>',
  pen: '<path d="M5 19l1-4L16.500 4.500l3 3L9 18zM14.500 6.500l3 3"/>',
  again: '<path d="M20 5v5h-5M19.500 10A8 8 0 1 0 20 14"/>',
  split: '<path d="M12 3v18M9 7H4v10h5M15 7h5v10h-5"/>',
  copy: '<path d="M9 9h11v11H9zM5 15H4V4h11v1"/>',
  lock: '<path d="M6.500 11h11v9h-11zM8.500 11V8a3.500 3.500 0 0 1 7 0v3"/>',
  trash: '<path d="M4 7h16M9.500 7V4.500h5V7M6.500 7l1 13h9l1-13M10 11v5M14 11v5"/>',
  plus: '<path d="M12 5v14M5 12h14"/>',
  minus: '<path d="M5 12h14"/>',
};

export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  svg.innerHTML = PATHS[name];
  return svg;
}

/** A button with an accessible name, a tooltip that also tells the key, and maybe an icon instead of text. */
export function button({ label, key, text, symbol, onclick, className = "", ...rest }) {
  const attributes = {
    type: "button", class: className, title: key ? `${label} (${key})` : label, onclick,
    "aria-label": text === label ? undefined : label, "aria-keyshortcuts": key, ...rest,
  };
  return h("button", attributes, symbol ? icon(symbol) : text);
}

export function press(element, on) {
  element.setAttribute("aria-pressed", String(Boolean(on)));
}

/** A select of [value, text] pairs. */
export function choice({ label, entries, onchange, className = "" }) {
  const element = h("select", { class: className, "aria-label": label, title: label, onchange: () => onchange(element.value) });
  element.append(...entries.map(([value, text]) => h("option", { value }, text)));
  return element;
}
