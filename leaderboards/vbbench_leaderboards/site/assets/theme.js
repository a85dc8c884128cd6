/* Light or dark: the system's choice, until the reader makes one. Runs in the head, before anything is painted. */
(function () {
  "use strict";
  const vbbench = (window.vbbench = window.vbbench || {});
  const root = document.documentElement;
  const KEY = "vbbench-theme";
  const system = window.matchMedia("(prefers-color-scheme: dark)");

  /** @returns {string | null} what the reader chose before */
  function remembered() {
    try {
      return localStorage.getItem(KEY);
    } catch (error) {
      return null; // some browsers keep nothing for pages from a file
    }
  }

  /** @param {string} theme */
  function remember(theme) {
    try {
      localStorage.setItem(KEY, theme);
    } catch (error) {
      // then it holds for this page only
    }
  }

  /** @returns {boolean} */
  function isDark() {
    return (root.dataset.theme || (system.matches ? "dark" : "light")) === "dark";
  }

  function show() {
    const button = document.getElementById("theme");
    if (button) button.setAttribute("aria-pressed", String(isDark()));
  }

  const chosen = remembered();
  if (chosen === "light" || chosen === "dark") root.dataset.theme = chosen;
  root.classList.add("scripted");
  if (location.search === "?player") root.classList.add("player-only"); // a page that shows the player in a frame

  document.addEventListener("DOMContentLoaded", function () {
    const button = document.getElementById("theme");
    show();
    system.addEventListener("change", show);
    button.addEventListener("click", function () {
      root.dataset.theme = isDark() ? "light" : "dark";
      remember(root.dataset.theme);
      show();
      window.dispatchEvent(new CustomEvent("vbbench-theme"));
    });
  });
  vbbench.isDark = isDark;
})();
