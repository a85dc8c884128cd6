/* What the address asks for is what the page shows: a board's table, its sequences in the player, two of its solvers,
   a solver's own page; and where it asks for nothing that there is, what lies near. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const { parse, format, replace, decoded } = vbbench.state;
  const picker = document.getElementById("picker");
  const listed = (name) => (picker.dataset[name] || "").split(" ").filter(Boolean);
  const [known, solvers, leading] = [listed("boards"), listed("solvers"), listed("leading")];
  const first = picker.dataset.first;
  const TITLE = ": results of vbbench";
  const places = Object.fromEntries(
    ["board", "player", "comparison", "page"].map((name) => [name, document.getElementById(name)]),
  );
  const boards = document.getElementById("boards");
  const back = document.getElementById("back");
  let turn = 0;
  let playing = "";

  /**
   * The board nearest to what is wanted: of the split, unless a tier is asked for that it does not have.
   * @param {string} split @param {string} protocol @param {string} tier @param {boolean} elsewhere
   */
  function nearest(split, protocol, tier, elsewhere) {
    const own = known.filter((key) => key.startsWith(split + "/"));
    const which = "/" + protocol + "-" + tier;
    return (
      own.find((key) => key === split + which) ||
      own.find((key) => key.endsWith("-" + tier)) ||
      (elsewhere && known.find((key) => key.endsWith(which))) ||
      own.find((key) => key.startsWith(split + "/" + protocol + "-")) ||
      own[0] ||
      first
    );
  }

  /** Links of the picker lead on from the board that is shown, to the same view. @param {string} key @param {any} on */
  function aim(key, on) {
    const [split, which] = key.split("/");
    const cut = which.lastIndexOf("-");
    const [protocol, tier] = [which.slice(0, cut), which.slice(cut + 1)];
    for (const link of picker.querySelectorAll("a")) {
      const own = link.dataset;
      const to = nearest(own.split || split, own.protocol || protocol, own.tier || tier, Boolean(own.tier));
      link.href = format({ board: to, ...on });
      const here = own.split === split || own.protocol === protocol || own.tier === tier;
      if (here) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    const kept = /** @type {HTMLDetailsElement | null} */ (document.getElementById("kept"));
    if (kept && kept.querySelector("[aria-current]")) kept.open = true;
  }

  /** Show one place and no other. @param {"board" | "player" | "comparison" | "page"} name */
  function only(name) {
    if (name !== "player" && playing) {
      vbbench.player.unmount();
      playing = "";
    }
    for (const [other, place] of Object.entries(places)) place.hidden = other !== name;
    document.body.dataset.view = name;
    back.hidden = name !== "player" && name !== "comparison";
  }

  /** @param {any} board */
  function leadBack(board) {
    back.firstElementChild.href = format({ board: board.key, view: "", options: {} });
  }

  /** @param {any} board @param {any} state */
  function showTable(board, state) {
    only("board");
    vbbench.boards.show(board, state, function (options) {
      const next = { ...state, options };
      replace(next);
      showTable(board, next);
    });
  }

  /** @returns {Promise<void>} */
  async function fetchPlayer() {
    if (vbbench.player) return;
    const style = document.createElement("link");
    style.rel = "stylesheet";
    style.href = "assets/player.css";
    document.head.append(style);
    await vbbench.script("assets/player.js");
  }

  /** @param {any} board @param {any} state @param {number} own */
  async function showPlayer(board, state, own) {
    await fetchPlayer();
    if (own !== turn) return;
    const arrives = !playing;
    if (playing) vbbench.player.unmount();
    only("player");
    playing = board.key;
    document.title = "Sequences of " + board.words + TITLE;
    leadBack(board);
    const onState = (options) => replace({ board: board.key, view: "play", options: asText(options) });
    vbbench.player.mount(places.player, { board, state: state.options, onState });
    if (arrives) back.scrollIntoView({ behavior: "instant" });
  }

  /** @param {Record<string, any>} options @returns {Record<string, string>} */
  function asText(options) {
    const given = Object.entries(options).filter(([, value]) => value !== undefined && value !== null);
    return Object.fromEntries(given.map(([name, value]) => [name, String(value)]));
  }

  /** @param {any} board @param {any} state @param {number} own */
  async function showComparison(board, state, own) {
    if (!vbbench.comparison) await vbbench.script("assets/compare.js");
    const found = await vbbench.comparison.load(board);
    if (own !== turn) return;
    const arrives = document.body.dataset.view !== "comparison";
    const show = function (options) {
      const chosen = vbbench.comparison.show(places.comparison, board, found, options, function (next) {
        replace({ board: board.key, view: "compare", options: next });
        show(next);
      });
      document.title = chosen.a + " and " + chosen.b + " on " + board.words + TITLE;
      aim(board.key, { view: "compare", options: { a: chosen.a, b: chosen.b } });
    };
    only("comparison");
    leadBack(board);
    show(state.options);
    if (arrives) arrive(places.comparison, back);
  }

  /** Where a view begins: seen, and read out. @param {HTMLElement} place @param {HTMLElement} top */
  function arrive(place, top) {
    focusHeading(place);
    top.scrollIntoView({ behavior: "instant" });
  }

  /** @param {HTMLElement} place of which the link that led here is gone */
  function focusHeading(place) {
    const heading = /** @type {HTMLElement | null} */ (place.querySelector("[tabindex='-1']"));
    if (heading) heading.focus({ preventScroll: true });
  }

  /** @param {string} name @param {number} own */
  async function showSolver(name, own) {
    const page = await vbbench.load("pages/solver/" + name);
    if (own !== turn) return;
    places.page.innerHTML = page.html; // written by the build, with every stranger's word escaped there
    document.title = name + TITLE;
    only("page");
    window.scrollTo({ top: 0, behavior: "instant" });
    arrive(places.page, document.body);
  }

  /** @param {string[]} parts of the address */
  function showUnknown(parts) {
    const paths = [...solvers.map((name) => "solver/" + name), ...leading, ...known];
    const near = vbbench.near(parts, [...new Set(paths)]);
    const words = parts[0] === "solver" ? "No solver of this name is here" : "No board of this name is here";
    const item = (address, text) => '<li><a href="' + address + '">' + text + "</a></li>";
    places.page.innerHTML =
      '<h1 id="missing-title" tabindex="-1"></h1><p><code></code></p><h2></h2><ul class="plain-list"></ul>';
    places.page.querySelector("h1").textContent = parts.length === 2 ? words : "There is no such page";
    places.page.querySelector("code").textContent = decoded(location.hash) || location.hash;
    places.page.querySelector("h2").textContent = near.length ? "What lies near" : "Where to go on";
    // Names of boards and solvers have nothing but letters, digits and . _ + - in them.
    const links = near.map((path) => item("#/" + path, path.replace("solver/", "solver ").replace("/", ", ")));
    places.page.querySelector("ul").innerHTML = [...links, item("#/", "All solvers and boards")].join("");
    document.title = "No such page" + TITLE;
    only("page");
    arrive(places.page, document.body);
  }

  /** @param {any} state @param {number} own */
  async function showBoard(state, own) {
    const key = state.kind === "board" ? state.board : first;
    const came = document.body.dataset.view;
    aim(key, { view: "", options: {} });
    const board = await vbbench.load(key);
    if (own !== turn) return;
    document.title = board.title + ", " + board.protocol + ", " + board.tier + TITLE;
    const films = state.view === "play" && board.playable.length;
    if (films) await showPlayer(board, state, own);
    else if (state.view === "compare" && board.solvers.length > 1) await showComparison(board, state, own);
    else {
      showTable(board, { ...state, board: key, view: "" });
      if (came && came !== "board") focusHeading(places.board);
    }
    if (state.view === "play" && !films) vbbench.boards.note("Its sequences cannot be watched: this page was built without them.");
    const narrow = window.matchMedia("(max-width: 48rem)").matches;
    if (own === 1 && !playing && state.kind === "board") (narrow ? places.board : boards).scrollIntoView({ behavior: "instant" });
  }

  async function route() {
    const state = parse(location.hash);
    const away = document.body.dataset.view === "page";
    if (state === null && turn > 0 && !away) return;
    const own = ++turn;
    const wanted = state || { kind: "front", board: "", view: "", options: {} };
    try {
      if (wanted.kind === "board" && known.includes(wanted.board)) await showBoard(wanted, own);
      else if (wanted.kind === "solver" && solvers.includes(wanted.solver)) await showSolver(wanted.solver, own);
      else if (wanted.kind === "front") await showBoard(wanted, own);
      else showUnknown(wanted.parts);
      if (away && state === null) document.querySelector(location.hash)?.scrollIntoView({ behavior: "instant" });
      else if (away && wanted.kind === "front") window.scrollTo({ top: 0, behavior: "instant" });
      else if (away && wanted.kind === "board") boards.scrollIntoView({ behavior: "instant" });
    } catch (error) {
      only("board");
      vbbench.boards.fail("This cannot be shown: " + error.message + ".");
    }
  }

  document.addEventListener("keydown", function (event) {
    const free = !(event.target instanceof Element && event.target.closest("select, input"));
    if (event.key === "Escape" && !event.defaultPrevented && free && document.body.dataset.view === "comparison") back.firstElementChild.click();
  });
  window.addEventListener("hashchange", route);
  route();
})();
