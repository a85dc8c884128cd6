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
