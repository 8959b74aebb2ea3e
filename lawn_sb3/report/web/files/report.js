// The report: tables sort, figures are enlarged, claims are filtered. Without it everything is there to read.
"use strict";
(() => {
  // The first number of a cell, such as -3.50 of "-3.50 [-3.60, -3.42]"; none if it begins with something else.
  const numberIn = (text) => {
    const found = text.trim().replaceAll("−", "-").match(/^[+-]?\d[\d,]*(\.\d+)?(e[+-]?\d+)?/i);
    return found ? Number(found[0].replaceAll(",", "")) : null;
  };
  const compared = (one, other) => {
    const [a, b] = [numberIn(one), numberIn(other)];
    if (a !== null && b !== null) return a - b;
    if (a !== null || b !== null) return a === null ? 1 : -1; // gaps and words below numbers
    return one.localeCompare(other);
  };
  for (const table of document.querySelectorAll("table.sorts")) {
    const body = table.tBodies[0];
    const asWritten = [...body.rows];
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      head.querySelector("button").addEventListener("click", () => {
        const next = { ascending: "descending", descending: null }; // a third click brings the written order back
        const before = head.getAttribute("aria-sort");
        const order = before === null ? "ascending" : next[before];
        table.querySelectorAll("[aria-sort]").forEach((other) => other.removeAttribute("aria-sort"));
        const sign = order === "descending" ? -1 : 1;
        const text = (row) => row.cells[column].textContent;
        body.append(...(order ? [...asWritten].sort((a, b) => sign * compared(text(a), text(b))) : asWritten));
        if (order) head.setAttribute("aria-sort", order);
      });
    });
  }

  const zoom = document.getElementById("zoom");
  for (const button of document.querySelectorAll("button.zoom")) {
    button.addEventListener("click", () => {
      const { src, alt } = button.querySelector("img");
      Object.assign(zoom.querySelector("img"), { src, alt });
      zoom.showModal();
    });
  }
  zoom.querySelector("img").addEventListener("click", () => zoom.close());

  for (const filters of document.querySelectorAll(".filters")) {
    const claims = filters.parentElement.querySelectorAll(".claims > details");
    const chosen = { verdict: "", carrying: false };
    filters.addEventListener("click", ({ target }) => {
      const button = target.closest("button");
      if (!button) return;
      if ("carrying" in button.dataset) chosen.carrying = !chosen.carrying;
      else chosen.verdict = button.dataset.verdict;
      for (const one of filters.children) {
        const pressed = "carrying" in one.dataset ? chosen.carrying : one.dataset.verdict === chosen.verdict;
        one.setAttribute("aria-pressed", pressed);
      }
      let shown = 0;
      for (const claim of claims) {
        const verdict = chosen.verdict === "" || claim.dataset.verdict === chosen.verdict;
        claim.hidden = !(verdict && (!chosen.carrying || "carrying" in claim.dataset));
        shown += !claim.hidden;
      }
      const pressed = filters.querySelector('[data-verdict][aria-pressed="true"]');
      const means = pressed.title ? `${chosen.verdict}: ${pressed.title}. ` : "";
      filters.parentElement.querySelector("#means").textContent = `${means}${shown} of ${claims.length} claims.`;
    });
  }
})();
