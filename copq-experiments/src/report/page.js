// Values under the pointer. All else on the page works without this script.
"use strict";
for (const figure of document.querySelectorAll("figure.curves")) {
  // A phone's figure has the numbers of the wide one before it.
  const data = JSON.parse((figure.querySelector("script") ?? figure.previousElementSibling.querySelector("script")).textContent);
  const svg = figure.querySelector("svg");
  const tip = figure.appendChild(document.createElement("div"));
  tip.className = "tip";
  const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
  line.setAttribute("class", "cross");
  const panels = [...svg.querySelectorAll("g.panel")].map((group, i) => {
    const [left, right, top, bottom] = group.dataset.frame.split(" ").map(Number);
    return { left, right, top, bottom, last: Number(group.dataset.range.split(" ")[0]), data: data.panels[i] };
  });
  const hide = () => { tip.style.display = "none"; line.remove(); };
  const place = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const isShown = (series) => document.querySelector("#m" + series)?.checked !== false;

  figure.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") hide(); });
  for (const kind of ["pointermove", "pointerdown"]) figure.addEventListener(kind, (event) => {
    const at = place(event);
    const panel = panels.find((p) => at.x >= p.left && at.x <= p.right && at.y >= p.top && at.y <= p.bottom);
    if (!panel) return hide();
    const step = (at.x - panel.left) / (panel.right - panel.left) * panel.last;
    const nearest = (curve) => curve.points.reduce((best, p) => Math.abs(p[0] - step) < Math.abs(best[0] - step) ? p : best);
    const rows = panel.data.curves
      .map((curve, series) => ({ curve, series }))
      .filter(({ curve, series }) => curve.points.length && isShown(series))
      .map(({ curve }) => ({ label: curve.label, seeds: curve.seeds, point: nearest(curve) }))
      // A curve that ended long before says nothing here.
      .filter(({ point }) => Math.abs(point[0] - step) <= panel.last / 20);
    if (!rows.length) return hide();
    const head = rows.reduce((best, row) => Math.abs(row.point[0] - step) < Math.abs(best.point[0] - step) ? row : best).point[0];
    tip.replaceChildren();
    tip.appendChild(document.createElement("b")).textContent = `${panel.data.title} at step ${whole(head)}`;
    for (const { label, point: [at, middle, low, high], seeds } of rows) {
      const own = at === head ? "" : ` at ${whole(at)}`;
      const row = tip.appendChild(document.createElement("div"));
      row.textContent = `${label}: ${shown(middle)} (${shown(low)} to ${shown(high)}; ${seeds} ${seeds === 1 ? "seed" : "seeds"})${own}`;
    }
    const x = panel.left + head / panel.last * (panel.right - panel.left);
    for (const [name, value] of [["x1", x], ["x2", x], ["y1", panel.top], ["y2", panel.bottom]]) line.setAttribute(name, value);
    svg.append(line);
    tip.style.display = "block";
    const box = figure.getBoundingClientRect();
    tip.style.left = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 4) + "px";
    tip.style.top = event.clientY - box.top + 14 + "px";
  });
}

function whole(step) {
  return Math.round(step).toLocaleString("en");
}

function shown(value) {
  return value.toLocaleString("en", { maximumSignificantDigits: 5 });
}
