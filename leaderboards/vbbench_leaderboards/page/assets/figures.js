/* Numbers as the build writes them (markup.py): two or three significant digits, points of a column in line. */
(function () {
  "use strict";

  /** @param {number} value @returns {number} the power of ten of its first digit, 0 for 0 */
  const power = (value) => (value ? Number(Math.abs(value).toExponential().split("e")[1]) : 0);

  /** @param {number} value @returns {number} */
  const toThreeDigits = (value) => Number(value.toPrecision(3));

  /** @param {(number | null)[]} values @returns {number} decimals of a column of figures */
  function decimals(values) {
    const sizes = values.filter((value) => value).map(Math.abs);
    return Math.min(4, Math.max(2, 1 - power(sizes.length ? Math.min(...sizes) : 1)));
  }

  /** @param {number} value @param {number} most @returns {number} */
  function figureDecimals(value, most) {
    return value ? Math.min(most, Math.max(0, 2 - power(toThreeDigits(value)))) : most;
  }

  /** @param {number} value @param {number} most decimals of its column @returns {string} */
  function figure(value, most) {
    const digits = figureDecimals(value, most);
    const shown = toThreeDigits(value).toLocaleString("en", {
      minimumFractionDigits: digits, maximumFractionDigits: digits,
    });
    return value > 0 && !Number(shown.replaceAll(",", "")) ? "<" + (10 ** -most).toFixed(most) : shown;
  }

  /** @param {number} value @param {number} most @returns {string} */
  function signed(value, most) {
    return (value < 0 ? "−" : "+") + figure(Math.abs(value), most);
  }

  /** @param {number | null} p @returns {string} */
  function chance(p) {
    if (p === null) return "–";
    return p < 0.0001 ? "< 0.0001" : p.toFixed(p < 0.1 ? 4 : 2);
  }

  window.vbbench.figures = { decimals, figure, figureDecimals, signed, chance };
})();
