// SPDX-License-Identifier: MIT
#include "edvo/report/html_assets.hpp"

namespace edvo {

const std::string_view kReportStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #f5f6f8; --card: #ffffff; --line: #e1e4e9; --text: #1b1f26; --soft: #5d6673;
  --accent: #0072b2; --good: #1a7f4b; --warn: #9a6200; --warn-back: #fff6e0; --bad: #b3261e;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #111418; --card: #1a1e24; --line: #2c323b; --text: #e8ebf0; --soft: #9aa4b2;
    --accent: #58b4ee; --good: #5bc98f; --warn: #eebb5c; --warn-back: #2b2415; --bad: #ff8a80;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0; background: var(--page); color: var(--text);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif;
}
main { max-width: 1240px; margin: 0 auto; padding: 28px 24px 60px; }
header { display: flex; gap: 16px; align-items: center; margin-bottom: 20px; }
header svg { flex: none; }
h1 { font-size: 25px; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 16px; margin: 0 0 2px; }
p { margin: 0; }
.soft { color: var(--soft); }
.badge {
  display: inline-block; padding: 1px 9px; border-radius: 99px; font-size: 13px; font-weight: 600;
  color: var(--accent); border: 1px solid currentColor; vertical-align: 3px; margin-left: 8px;
  white-space: nowrap;
}
.badge.bad { color: var(--bad); }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(230px, 1fr)); gap: 12px; }
.tile, .card { background: var(--card); border: 1px solid var(--line); border-radius: 10px; }
.tile { padding: 12px 16px 11px; }
.tile .name { font-size: 13px; color: var(--soft); }
.tile .value { font-size: 27px; font-weight: 650; line-height: 1.25; letter-spacing: -.01em;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
.tile .value small { font-size: 15px; font-weight: 500; color: var(--soft); margin-left: 3px; }
.tile .more { font-size: 12.5px; color: var(--soft); line-height: 1.4; }
.tile.good .value { color: var(--good); }
.tile.bad .value { color: var(--bad); }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 500px), 1fr));
  gap: 14px; margin-top: 14px; }
.card { padding: 14px 18px; min-width: 0; }
.card > .soft { font-size: 13px; }
.card svg { display: block; margin: 6px auto 0; width: 100%; }
svg text { fill: var(--soft); }
.wide { margin-top: 14px; }
.warnings { background: var(--warn-back); border-color: var(--warn); margin-bottom: 14px; }
.warnings h2 { color: var(--warn); }
ul { margin: 4px 0 0; padding-left: 20px; }
li { overflow-wrap: anywhere; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 14px;
  width: 100%; }
th { text-align: left; color: var(--soft); font-weight: 500; white-space: nowrap; }
th, td { padding: 4px 14px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
tr:last-child > * { border-bottom: 0; }
.number { text-align: right; white-space: nowrap; }
td.text { overflow-wrap: anywhere; }
.scroll { max-height: 330px; overflow: auto; margin-top: 8px; }
.scroll thead th { position: sticky; top: 0; background: var(--card); }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(210px, 1fr)); gap: 14px;
  margin-top: 10px; }
.pictures figure { margin: 0; border-radius: 8px; }
.pictures img { display: block; width: 100%; max-width: 320px; border-radius: 8px; }
.pictures figcaption { font-size: 12.5px; line-height: 1.4; margin-top: 5px; }
:target { outline: 3px solid var(--accent); outline-offset: 4px; }
#space canvas { display: block; width: 100%; height: 480px; touch-action: none; cursor: grab; }
a.event { cursor: pointer; }
.compact th, .compact td { white-space: normal; padding-right: 10px; font-size: 13px; }
.compact th[scope] { white-space: nowrap; }
.swatch { display: inline-block; width: 11px; height: 11px; border-radius: 3px; margin-right: 8px; }
pre { margin: 8px 0 0; padding: 12px 14px; background: var(--page); border: 1px solid var(--line);
  border-radius: 8px; overflow-x: auto; font: 13px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }
summary { cursor: pointer; font-weight: 600; font-size: 16px; }
button { font: inherit; font-size: 13px; color: var(--accent); background: none; cursor: pointer;
  border: 1px solid var(--line); border-radius: 6px; padding: 1px 10px; margin-left: 10px; }
a { color: var(--accent); }
#tip { position: fixed; pointer-events: none; display: none; z-index: 5; background: var(--card);
  border: 1px solid var(--line); border-radius: 8px; padding: 7px 11px; font-size: 12.5px;
  line-height: 1.45; box-shadow: 0 4px 18px #0004; font-variant-numeric: tabular-nums;
  white-space: pre; }
@media (max-width: 600px) {
  main { padding: 18px 12px 40px; }
  .tiles { grid-template-columns: 1fr 1fr; gap: 8px; }
  .tile { padding: 10px 12px; }
  .tile .value { font-size: 23px; }
}
@media print { body { background: none; } .card, .tile { break-inside: avoid; } }
)css";

const std::string_view kReportScript = R"js(
"use strict";
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const tip = document.getElementById("tip");
  const route = JSON.parse(document.getElementById("route").textContent);  // [s, frame, x, y, z]

  // What each plot says about itself: the axes' place and range, and the points of its lines.
  const plots = [...document.querySelectorAll("figure svg[data-area]")].map((svg) => {
    const [left, top, width, height, x0, x1, y0, y1] = svg.dataset.area.split(" ").map(Number);
    const figure = svg.closest("figure");
    const lines = [...svg.querySelectorAll("path.series")].map((path) => ({
      name: path.querySelector("title").textContent,
      color: path.getAttribute("stroke") || path.getAttribute("fill"),
      points: [...path.getAttribute("d").matchAll(/([ML])([-\d.]+) ([-\d.]+)/g)]
        .map((m) => [Number(m[2]), Number(m[3]), m[1] === "M"]),
    }));
    svg.querySelectorAll("path.series title").forEach((title) => title.remove());
    const stacked = figure.dataset.kind === "stack";
    if (stacked) lines.reverse();
    const cursor = document.createElementNS(SVG, figure.dataset.kind === "map" ? "circle" : "path");
    cursor.setAttribute("stroke", "currentColor");
    cursor.setAttribute("r", 5);
    cursor.setAttribute("stroke-width", figure.dataset.kind === "map" ? 2 : 1);
    cursor.setAttribute("fill", "none");
    cursor.style.display = "none";
    svg.append(cursor);
    const px = (x) => left + (x - x0) / (x1 - x0) * width;
    const py = (y) => top + (y1 - y) / (y1 - y0) * height;
    const value = (y) => y1 - (y - top) / height * (y1 - y0);
    return { svg, figure, lines, stacked, cursor, left, top, width, height, x0, x1, px, py, value };
  });

  const at = (points, x) => {
    let low = 0, high = points.length - 1;
    if (high < 0 || x < points[0][0] || x > points[high][0]) return null;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (points[middle][0] <= x) low = middle; else high = middle;
    }
    const [a, b] = [points[low], points[high]];
    if (b[2] && b[0] > x) return null;  // in a gap of the line
    return b[0] > a[0] ? a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]) : a[1];
  };
  const nearest = (seconds) => {
    let low = 0, high = route.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (route[middle][0] <= seconds) low = middle; else high = middle;
    }
    return seconds - route[low][0] < route[high][0] - seconds ? route[low] : route[high];
  };
  const short = (v) => Math.abs(v) >= 100 ? v.toFixed(0) : Math.abs(v) >= 10 ? v.toFixed(1)
    : Math.abs(v) >= 0.1 ? v.toFixed(3) : v.toFixed(4);

  // For the view in space.
  const tellPlace = (place) => document.dispatchEvent(new CustomEvent("edvo-frame", { detail: place }));
  const show = (seconds, here, event) => {
    const frame = route.length ? nearest(seconds) : null;
    for (const plot of plots) {
      if (plot.figure.dataset.kind === "map" && !frame) continue;
      plot.cursor.style.display = "";
      if (plot.figure.dataset.kind === "map") {
        plot.cursor.setAttribute("cx", plot.px(frame[2 + Number(plot.figure.dataset.right)]));
        plot.cursor.setAttribute("cy",
          plot.py(Number(plot.figure.dataset.sign) * frame[2 + Number(plot.figure.dataset.up)]));
      } else {
        plot.cursor.setAttribute("d", `M${plot.px(seconds)} ${plot.top}v${plot.height}`);
      }
    }
    tellPlace(frame && frame.slice(2));
    tip.replaceChildren(`${seconds.toFixed(2)} s` + (frame ? `   frame ${frame[1]}` : ""));
    let below = 0;
    for (const line of here.lines) {
      const y = at(line.points, here.px(seconds));
      if (y === null) continue;
      const swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = line.color;
      const total = here.value(y);
      tip.append("\n", swatch, `${line.name}  ${short(here.stacked ? total - below : total)}`);
      if (here.stacked) below = total;
    }
    if (here.stacked) tip.append(`\ntotal  ${short(below)}`);
    tip.style.display = "block";
    const right = event.clientX + 18 + tip.offsetWidth < innerWidth;
    tip.style.left = `${right ? event.clientX + 18 : event.clientX - 18 - tip.offsetWidth}px`;
    tip.style.top = `${Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8)}px`;
  };
  const hide = () => {
    tellPlace(null);
    tip.style.display = "none";
    for (const plot of plots) plot.cursor.style.display = "none";
  };
  for (const plot of plots) {
    if (plot.figure.dataset.kind === "map") continue;
    plot.svg.addEventListener("pointermove", (event) => {
      const box = plot.svg.getBoundingClientRect();
      const x = (event.clientX - box.left) * plot.svg.viewBox.baseVal.width / box.width;
      const share = (x - plot.left) / plot.width;
      if (share < 0 || share > 1) hide();
      else show(plot.x0 + share * (plot.x1 - plot.x0), plot, event);
    });
    plot.svg.addEventListener("pointerleave", hide);
  }

  const copy = document.getElementById("copy");
  if (copy && navigator.clipboard) copy.addEventListener("click", () => {
    navigator.clipboard.writeText(document.getElementById("command").textContent)
      .then(() => { copy.textContent = "copied"; });
  }); else copy?.remove();
})();
)js";

}  // namespace edvo
