/* What the address asks for is what the page shows: a board's table, or its sequences in the player. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const { parse, format, replace } = vbbench.state;
  const picker = document.getElementById("picker");
  const known = (picker.dataset.boards || "").split(" ");
  const first = picker.dataset.first;
  const boardPlace = document.getElementById("board");
  const playerPlace = document.getElementById("player");
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

  /** Links of the picker lead on from the board that is shown. @param {string} key */
  function aim(key) {
    const [split, which] = key.split("/");
    const cut = which.lastIndexOf("-");
    const [protocol, tier] = [which.slice(0, cut), which.slice(cut + 1)];
    for (const link of picker.querySelectorAll("a")) {
      const own = link.dataset;
      const to = nearest(own.split || split, own.protocol || protocol, own.tier || tier, Boolean(own.tier));
      link.href = format({ board: to, play: false, options: {} });
      const here = own.split === split || own.protocol === protocol || own.tier === tier;
      if (here) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    const kept = /** @type {HTMLDetailsElement | null} */ (document.getElementById("kept"));
    if (kept && kept.querySelector("[aria-current]")) kept.open = true;
  }

  /** @param {any} board @param {any} state */
  function showTable(board, state) {
    stopPlayer();
    boardPlace.hidden = false;
    vbbench.boards.show(board, state, function (options) {
      const next = { ...state, options };
      replace(next);
      showTable(board, next);
    });
  }

  function stopPlayer() {
    if (playing) vbbench.player.unmount();
    playing = "";
    playerPlace.hidden = true;
    back.hidden = true;
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
    playing = board.key;
    back.hidden = false;
    back.firstElementChild.href = format({ board: board.key, play: false, options: {} });
    boardPlace.hidden = true;
    playerPlace.hidden = false;
    const onState = (options) => replace({ board: board.key, play: true, options: asText(options) });
    vbbench.player.mount(playerPlace, { board, state: state.options, onState });
    if (arrives) back.scrollIntoView({ behavior: "instant" });
  }

  /** @param {Record<string, any>} options @returns {Record<string, string>} */
  function asText(options) {
    const given = Object.entries(options).filter(([, value]) => value !== undefined && value !== null);
    return Object.fromEntries(given.map(([name, value]) => [name, String(value)]));
  }

  async function route() {
    const state = parse(location.hash);
    if (state === null && turn > 0) return;
    const wanted = state && known.includes(state.board) ? state : { board: first, play: false, options: {} };
    const own = ++turn;
    aim(wanted.board);
    try {
      const board = await vbbench.load(wanted.board);
      if (own !== turn) return;
      document.title = board.title + ", " + board.protocol + ", " + board.tier + ": results of vbbench";
      if (wanted.play && board.playable.length) await showPlayer(board, wanted, own);
      else showTable(board, { ...wanted, play: false });
      if (own === 1 && !playing && state && state.board) boards.scrollIntoView({ behavior: "instant" });
    } catch (error) {
      stopPlayer();
      boardPlace.hidden = false;
      vbbench.boards.fail("This board cannot be shown: " + error.message + ".");
    }
  }

  window.addEventListener("hashchange", route);
  route();
})();
