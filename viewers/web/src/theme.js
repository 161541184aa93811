// Colours of the scene; those of the controls are in style.css.

export const THEMES = {
  dark: {
    centre: "#46505f",
    middle: "#2a313b",
    edge: "#15181d",
    grid: "#dfe8ff",
    gridStrength: 0.13,
    pool: "#9db7e0",
    poolStrength: 0.1,
    shadow: 0.5,
    sky: "#dfe9ff",
    ground: "#4a4f5a",
    ambient: 1.15,
    key: 2.8,
    rim: "#9cc3ff",
    rimStrength: 1.7,
    ghost: "#93a0b5",
    accent: "#5b9dff",
    contact: "#58d19a",
    pin: "#f4b740",
    joint: "#f2f5fa",
    edgeGlow: 0.13,
  },
  light: {
    centre: "#f4f6fa",
    middle: "#e3e8f0",
    edge: "#c3ccda",
    grid: "#24324a",
    gridStrength: 0.22,
    pool: "#ffffff",
    poolStrength: 0.4,
    shadow: 0.3,
    sky: "#ffffff",
    ground: "#b9bfca",
    ambient: 1.7,
    key: 2.3,
    rim: "#ffffff",
    rimStrength: 1.2,
    ghost: "#8090a8",
    accent: "#2f6fe0",
    contact: "#12995f",
    pin: "#c77700",
    joint: "#3a4250",
    edgeGlow: 0.05,
  },
};

/** "auto" follows the system's setting. */
export function resolveTheme(name) {
  if (name === "light" || name === "dark") return name;
  return globalThis.matchMedia?.("(prefers-color-scheme: light)").matches ? "light" : "dark";
}
