// SPDX-License-Identifier: MIT
#include "edvo/report/html_assets.hpp"

namespace edvo {

const std::string_view kSpaceScript = R"js(
"use strict";
(() => {
  const card = document.getElementById("space");
  if (!card) return;
  const lines = JSON.parse(card.querySelector("script").textContent);
  const canvas = document.createElement("canvas");
  const ink = canvas.getContext("2d");
  if (!ink) return;
  const picture = card.querySelector("svg");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "trajectories in space; the arrow keys turn the view");
  picture.replaceWith(canvas);
  card.querySelector(".how").hidden = false;

  // The box around all points: its centre is what the view turns about.
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const line of lines)
    for (const point of line.points)
      if (point) point.forEach((v, k) => {
        low[k] = Math.min(low[k], v);
        high[k] = Math.max(high[k], v);
      });
  const centre = low.map((v, k) => (v + high[k]) / 2);
  const radius = Math.max(1e-3, Math.hypot(...low.map((v, k) => high[k] - v)) / 2);
  const first = { yaw: -0.6, pitch: 0.5, zoom: 1, right: 0, up: 0 };
  let view = { ...first };
  let cursor = null;  // a place that the mouse shows in another plot

  // Pixels of a point (x right, y up, z ahead), a little smaller the farther it is.
  const project = ([x, y, z]) => {
    const [cx, cy, cz] = [x - centre[0], y - centre[1], z - centre[2]];
    const right = Math.cos(view.yaw) * cx + Math.sin(view.yaw) * cz;
    const ahead = Math.cos(view.yaw) * cz - Math.sin(view.yaw) * cx;
    const up = Math.cos(view.pitch) * cy + Math.sin(view.pitch) * ahead;
    const far = Math.cos(view.pitch) * ahead - Math.sin(view.pitch) * cy;
    const scale = 0.46 * Math.min(canvas.clientWidth, canvas.clientHeight) * view.zoom / radius
      * 4 / (4 + far / radius);
    return [canvas.clientWidth / 2 + view.right + scale * right,
      canvas.clientHeight / 2 + view.up - scale * up];
  };
  const stroke = (points, color, width) => {
    ink.beginPath();
    let open = false;
    for (const point of points) {
      if (point) ink[open ? "lineTo" : "moveTo"](...project(point));
      open = point !== null;
    }
    ink.strokeStyle = color;
    ink.lineWidth = width;
    ink.stroke();
  };
  const dot = (point, color, size) => {
    ink.beginPath();
    ink.arc(...project(point), size, 0, 2 * Math.PI);
    ink.fillStyle = color;
    ink.fill();
  };
  // Squares of 1, 2 or 5 times a power of ten below the lowest point.
  const floor = () => {
    const power = 10 ** Math.floor(Math.log10(radius / 2));
    const step = [5, 2, 1].map((f) => f * power).find((s) => s <= radius / 2) || power;
    const from = (k) => Math.floor(low[k] / step) * step, to = (k) => Math.ceil(high[k] / step) * step;
    const soft = "#88888855", y = low[1];
    for (let x = from(0); x <= to(0) + step / 2; x += step)
      stroke([[x, y, from(2)], [x, y, to(2)]], soft, 1);
    for (let z = from(2); z <= to(2) + step / 2; z += step)
      stroke([[from(0), y, z], [to(0), y, z]], soft, 1);
    return step;
  };
  const legend = (step) => {
    ink.font = "13px system-ui, sans-serif";
    ink.textBaseline = "middle";
    lines.forEach((line, i) => {
      ink.fillStyle = line.color;
      ink.fillRect(12, 14 + 20 * i, 20, 4);
      ink.fillStyle = getComputedStyle(card).color;
      ink.fillText(line.name, 40, 16 + 20 * i);
    });
    ink.fillText(`squares of ${+step.toPrecision(1)} m; red: right, green: up, blue: ahead`, 12,
      canvas.clientHeight - 14);
  };
  const draw = () => {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    ink.setTransform(ratio, 0, 0, ratio, 0, 0);
    ink.lineJoin = ink.lineCap = "round";
    const step = floor();
    [["#d62728", 0], ["#2ca02c", 1], ["#1f77b4", 2]].forEach(([color, k]) => {
      const tip = [0, 0, 0];
      tip[k] = step / 2;
      stroke([[0, 0, 0], tip], color, 3);  // the first camera
    });
    for (const line of lines) {
      if (line.dots) line.points.forEach((point) => point && dot(point, line.color, 2.5));
      else stroke(line.points, line.color, 1.8);
    }
    if (cursor) dot(cursor, getComputedStyle(card).color, 5);
    legend(step);
  };

  const turn = (yaw, pitch) => {
    view.yaw += yaw;
    view.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.pitch + pitch));
    draw();
  };
  const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    turn(...keys[event.key]);
  });
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    if (event.shiftKey) {
      view.right += event.movementX;
      view.up += event.movementY;
      draw();
    } else turn(-0.008 * event.movementX, 0.008 * event.movementY);
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;  // else the page could not be scrolled
    event.preventDefault();
    view.zoom *= Math.exp(-0.0015 * event.deltaY);
    draw();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { view = { ...first }; draw(); });
  document.addEventListener("edvo-frame", (event) => {
    const place = event.detail;
    cursor = place && [place[0], Number(card.dataset.sign) * place[1], place[2]];
    draw();
  });
  new ResizeObserver(draw).observe(canvas);
})();
)js";

}  // namespace edvo
