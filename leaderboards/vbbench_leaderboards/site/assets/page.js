/* What every page has: light or dark, data on demand, addresses. Runs in the head, before anything is painted. */
"use strict";
window.vbbench = (function () {
  const KEY = "vbbench-theme", VIEWS = ["play"];
  const root = document.documentElement, system = matchMedia("(prefers-color-scheme: dark)");

  /** Read or keep the reader's choice; some browsers keep nothing for pages from a file. */
  function storage(use) {
    try {
      return use(localStorage);
    } catch (error) {
      return null;
    }
  }

  const isDark = () => (root.dataset.theme || (system.matches ? "dark" : "light")) === "dark";

  function startTheme() {
    const button = document.getElementById("theme");
    if (!button) return;
    const show = () => button.setAttribute("aria-pressed", String(isDark()));
    show();
    system.addEventListener("change", show);
    button.addEventListener("click", () => {
      root.dataset.theme = isDark() ? "light" : "dark";
      storage((kept) => kept.setItem(KEY, root.dataset.theme));
      show();
    });
  }

  const chosen = storage((kept) => kept.getItem(KEY));
  if (chosen === "light" || chosen === "dark") root.dataset.theme = chosen;
  root.classList.add("scripted");
  document.addEventListener("DOMContentLoaded", startTheme);

  /* Alone in a frame of another page the player says how high it is, and that page makes the frame as high. */
  if (location.search === "?player") {
    root.classList.add("player-only");
    const say = () => parent.postMessage({ playerHeight: Math.ceil(document.body.getBoundingClientRect().height) }, "*");
    document.addEventListener("DOMContentLoaded", () => new ResizeObserver(say).observe(document.body));
  }
  addEventListener("message", ({ data, source }) => {
    const frame = [...document.querySelectorAll("iframe")].find((each) => each.contentWindow === source);
    if (frame && data.playerHeight > 0) frame.style.height = `${data.playerHeight + 2}px`; // and its borders
  });

  /* A file of data is a script that calls `provide`, so it loads from file:// too. */
  const values = new Map(), asked = new Map();
  const provide = (key, value) => { values.set(key, value); };

  /** A promise that is kept when the script at an address, relative to the page, has run. */
  function script(address) {
    return new Promise((resolve, reject) => {
      const onerror = () => reject(new Error(`${address} cannot be loaded`));
      document.head.append(make("script", { src: address, onload: resolve, onerror }));
    });
  }

  /** The value of a key, from data/KEY.js. */
  function load(key) {
    if (!asked.has(key)) {
      const answer = script(`data/${key.split("/").map(encodeURIComponent).join("/")}.js`).then(() => values.get(key));
      answer.catch(() => asked.delete(key));
      asked.set(key, answer);
    }
    return asked.get(key);
  }

  /* The address is the state: #/SPLIT/PROTOCOL-TIER?by=dx&show=… for a table, …/play?sequence=12 for the player,
     and #/solver/NAME for a solver. */
  function decoded(text) {
    try {
      return decodeURIComponent(text);
    } catch (error) {
      return "";
    }
  }

  /** { kind, board, view, solver, parts, options } of an address; null for a place on the page, such as #meanings. */
  function parse(hash) {
    if (hash && hash !== "#" && !hash.startsWith("#/")) return null;
    const [path, query] = hash.replace(/^#\/?/, "").split("?");
    const parts = path.split("/").filter(Boolean).map(decoded), options = Object.fromEntries(new URLSearchParams(query));
    const [first, second, view = ""] = parts, state = { kind: "unknown", board: "", view: "", solver: "", parts, options };
    if (!parts.length) return { ...state, kind: "front" };
    if (parts.length === 2 && first === "solver") return { ...state, kind: "solver", solver: second };
    const isBoard = parts.length === 2 || (parts.length === 3 && VIEWS.includes(view));
    return isBoard ? { ...state, kind: "board", board: `${first}/${second}`, view } : state;
  }

  function format({ board, view = "", options = {} }) {
    const path = board.split("/").map(encodeURIComponent).join("/");
    const kept = Object.entries(options).filter(([, value]) => value !== "" && value != null);
    const query = new URLSearchParams(kept).toString().replaceAll("%2C", ",");
    return `#/${path}${view && `/${view}`}${query && `?${query}`}`;
  }

  /** An element; text is text, whoever wrote it, and `on…` are listeners. */
  function make(name, facts, ...parts) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(facts)) {
      if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (value !== undefined) element.setAttribute(key, value);
    }
    element.append(...parts);
    return element;
  }

  return { isDark, provide, script, load, make, address: { decoded, parse, format } };
})();
