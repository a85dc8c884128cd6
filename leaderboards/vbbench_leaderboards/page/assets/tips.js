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
