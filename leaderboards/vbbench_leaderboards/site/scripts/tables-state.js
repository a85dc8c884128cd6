/* Data on demand: a file of data is a script that calls vbbench.provide, so it loads from file:// too. */
(function () {
  "use strict";
  const vbbench = (window.vbbench = window.vbbench || {});

  /** @type {Map<string, any>} */
  const values = new Map();
  /** @type {Map<string, Promise<any>>} */
  const asked = new Map();

  /**
   * Called by a data file.
   * @param {string} key
   * @param {any} value
   */
  vbbench.provide = function (key, value) {
    values.set(key, value);
  };

  /**
   * @param {string} address relative to the page
   * @returns {Promise<void>} settled when the script has run
   */
  vbbench.script = function (address) {
    return new Promise(function (resolve, reject) {
      const script = document.createElement("script");
      script.src = address;
      script.onload = () => resolve();
      script.onerror = () => reject(new Error(address + " cannot be loaded"));
      document.head.append(script);
    });
  };

  /**
   * The value of a key, from data/KEY.js.
   * @param {string} key
   * @returns {Promise<any>}
   */
  vbbench.load = function (key) {
    if (values.has(key)) return Promise.resolve(values.get(key));
    if (!asked.has(key)) {
      const address = "data/" + key.split("/").map(encodeURIComponent).join("/") + ".js";
      const answer = vbbench.script(address).then(() => values.get(key));
      answer.catch(() => asked.delete(key));
      asked.set(key, answer);
    }
    return asked.get(key);
  };
})();
/* The address is the state: #/SPLIT/PROTOCOL-TIER?by=dx&show=… for a table, …/play?sequence=12 for the player,
   …/compare?a=…&b=… for two solvers, and #/solver/NAME for one. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const VIEWS = ["play", "compare"];

  /**
   * @typedef {object} State
   * @property {"front" | "board" | "solver" | "unknown"} kind
   * @property {string} board split/protocol-tier, or "" where it is no board
   * @property {string} view of a board: "" for its table, "play" or "compare"
   * @property {string} solver its name, or "" where it is no solver's page
   * @property {string[]} parts of the path
   * @property {Record<string, string>} options
   */

  /** @param {string} text @returns {string} */
  function decoded(text) {
    try {
      return decodeURIComponent(text);
    } catch (error) {
      return "";
    }
  }

  /**
   * @param {string} hash
   * @returns {State | null} null for a place on the page, such as #meanings
   */
  function parse(hash) {
    if (hash && hash !== "#" && !hash.startsWith("#/")) return null;
    const [path, query] = hash.replace(/^#\/?/, "").split("?");
    const parts = path.split("/").filter(Boolean).map(decoded);
    const options = Object.fromEntries(new URLSearchParams(query || ""));
    const state = { kind: "unknown", board: "", view: "", solver: "", parts, options };
    if (parts.length === 0) return { ...state, kind: "front" };
    if (parts.length === 2 && parts[0] === "solver") return { ...state, kind: "solver", solver: parts[1] };
    if (parts.length === 2) return { ...state, kind: "board", board: parts.join("/") };
    if (parts.length === 3 && VIEWS.includes(parts[2])) {
      return { ...state, kind: "board", board: parts.slice(0, 2).join("/"), view: parts[2] };
    }
    return state;
  }

  /** @param {{board: string, view: string, options: Record<string, string>}} state @returns {string} */
  function format(state) {
    const path = state.board.split("/").map(encodeURIComponent).join("/");
    const kept = Object.entries(state.options).filter(([, value]) => value !== "" && value != null);
    const query = new URLSearchParams(kept).toString().replaceAll("%2C", ",");
    return "#/" + path + (state.view ? "/" + state.view : "") + (query ? "?" + query : "");
  }

  /** @param {{board: string, view: string, options: Record<string, string>}} state */
  function replace(state) {
    history.replaceState(null, "", format(state));
  }

  vbbench.state = { parse, format, replace, decoded };
})();
/* Tooltips: what a word means, or what a mark of a chart says; on hover and focus, gone with Escape. */
(function () {
  "use strict";
  const tip = document.getElementById("tip");
  const SOURCE = "[data-def], [data-tip]";
  /** @type {Element | null} */
  let owner = null;

  /** @param {Element} element @returns {string} */
  function words(element) {
    const definition = element.getAttribute("data-def");
    if (!definition) return element.getAttribute("data-tip") || "";
    const found = document.getElementById(definition);
    return found ? found.textContent : "";
  }

  /** @param {Element} element */
  function show(element) {
    const text = words(element);
    if (!text) return;
    owner = element;
    tip.textContent = text;
    tip.hidden = false;
    place(element.getBoundingClientRect());
  }

  /** @param {DOMRect} at */
  function place(at) {
    const own = tip.getBoundingClientRect();
    const room = document.documentElement.clientWidth - own.width - 8;
    const below = at.bottom + 8 + own.height < window.innerHeight;
    tip.style.left = Math.max(8, Math.min(room, at.left + at.width / 2 - own.width / 2)) + "px";
    tip.style.top = (below ? at.bottom + 8 : Math.max(8, at.top - own.height - 8)) + "px";
  }

  function follow() {
    if (owner) place(owner.getBoundingClientRect());
  }

  function hide() {
    owner = null;
    tip.hidden = true;
  }

  /** @param {Event} event */
  function enter(event) {
    const element = event.target instanceof Element && event.target.closest(SOURCE);
    if (element && element !== owner) show(element);
  }

  /** @param {MouseEvent | FocusEvent} event */
  function leave(event) {
    const to = event.relatedTarget instanceof Node ? event.relatedTarget : null;
    if (owner && owner.contains(/** @type {Node} */ (event.target)) && !owner.contains(to)) hide();
  }

  document.addEventListener("mouseover", enter);
  document.addEventListener("focusin", enter);
  document.addEventListener("mouseout", leave);
  document.addEventListener("focusout", leave);
  document.addEventListener("scroll", follow, { capture: true, passive: true });
  document.addEventListener("keydown", function (event) {
    if (event.key !== "Escape" || !owner) return;
    hide();
    event.preventDefault();
  });
})();
/* What lies near an address that leads nowhere. */
(function () {
  "use strict";
  const MOST = 5;
  const TOO_FAR = 1.3;
  const UNSAID = 0.3;

  /** @param {string} one @param {string} other @returns {number} share of letters to change, 0 = the same */
  function unlikeness(one, other) {
    const [a, b] = [one.toLowerCase(), other.toLowerCase()];
    let row = Array.from({ length: b.length + 1 }, (_, n) => n);
    for (let i = 1; i <= a.length; i++) {
      const next = [i];
      for (let j = 1; j <= b.length; j++) {
        next.push(Math.min(next[j - 1] + 1, row[j] + 1, row[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1)));
      }
      row = next;
    }
    return row[b.length] / Math.max(a.length, b.length, 1);
  }

  /**
   * The known paths nearest to a path, the nearest first; of those that are equally near, the first.
   * @param {string[]} parts
   * @param {string[]} known such as "hotel/one-step-noisy", those that matter most first
   * @returns {string[]}
   */
  function near(parts, known) {
    const far = (path) => {
      const own = path.split("/");
      const rest = parts.length > 1 ? unlikeness(parts[1], own[1]) : UNSAID;
      return 2 * unlikeness(parts[0] || "", own[0]) + rest;
    };
    const found = known.map((path, n) => ({ path, n, far: far(path) })).filter((one) => one.far < TOO_FAR);
    return found.sort((one, two) => one.far - two.far || one.n - two.n).slice(0, MOST).map((one) => one.path);
  }

  window.vbbench.near = near;
})();
