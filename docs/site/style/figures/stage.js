// Figures that are dragged. A place <div data-figure="cone"></div> becomes a drawing with handles, sliders and a
// sentence; `data-result` of the place holds what the figure has computed, for tests and for whoever asks.
// A figure is a function of its stage; it makes its handles and sliders and returns what draws and tells.
"use strict";

window.Figures = { start: {} };

(() => {
  const SPACE = "http://www.w3.org/2000/svg";
  const WIDTH = 520; // of a drawing [its own units]; the page scales it
  const STEP = 0.02; // of an arrow key, as a share of what is shown
  const REACH = 32; // around a handle: on a phone 44 pixels across, what a finger needs

  function node(name, attributes, parent) {
    const made = document.createElementNS(SPACE, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    parent.appendChild(made);
    return made;
  }

  class Stage {
    constructor(place, x, y) {
      this.place = place;
      this.chinese = document.documentElement.lang.startsWith("zh");
      [this.x, this.y] = [x, y];
      this.scale = WIDTH / (x[1] - x[0]);
      const height = this.scale * (y[1] - y[0]);
      this.svg = node("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "group" }, place);
      this.drawn = node("g", {}, this.svg);
      this.reaches = node("g", {}, this.svg); // below all handles: each is taken by what is seen of it
      this.handles = node("g", {}, this.svg);
      this.controls = place.appendChild(document.createElement("div"));
      this.sentence = place.appendChild(document.createElement("p"));
      this.sentence.setAttribute("aria-live", "polite");
      this.moved = () => {};
    }

    say(english, chinese) {
      return this.chinese ? chinese : english;
    }

    pixel([x, y]) {
      return [(x - this.x[0]) * this.scale, (this.y[1] - y) * this.scale];
    }

    line(points, look, closed = false) {
      const path = points.map((point) => this.pixel(point).map((value) => value.toFixed(1)).join(",")).join(" ");
      return node(closed ? "polygon" : "polyline", { points: path, class: look }, this.drawn);
    }

    circle(centre, radius, look) {
      const [cx, cy] = this.pixel(centre);
      return node("circle", { cx, cy, r: radius * this.scale, class: look }, this.drawn);
    }

    arrow(from, to, look) {
      const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
      const length = Math.hypot(dx, dy);
      if (length * this.scale < 2) return;
      const head = Math.min(10 / this.scale, length) / length;
      const back = [to[0] - head * dx, to[1] - head * dy];
      this.line([from, back], look);
      const side = [-0.4 * head * dy, 0.4 * head * dx];
      const barbs = [[back[0] + side[0], back[1] + side[1]], [back[0] - side[0], back[1] - side[1]]];
      this.line([to, ...barbs], `${look} head`, true);
    }

    text(at, words, look = "") {
      const [x, y] = this.pixel(at);
      node("text", { x, y, class: look }, this.drawn).textContent = words;
    }

    // A point that follows the mouse, a finger or the arrow keys; `kept` puts a wish where it may be.
    handle(name, start, kept = (point) => point) {
      const point = { at: kept(start) };
      const dot = node("circle", { r: 9, class: "handle", tabindex: 0, role: "button", "aria-label": name }, this.handles);
      node("title", {}, dot).textContent = name;
      const reach = node("circle", { r: REACH, class: "reach" }, this.reaches);
      const move = (wish) => {
        const inside = [
          Math.min(Math.max(wish[0], this.x[0]), this.x[1]),
          Math.min(Math.max(wish[1], this.y[0]), this.y[1]),
        ];
        point.at = kept(inside);
        this.moved();
      };
      for (const part of [dot, reach]) {
        part.addEventListener("pointerdown", (event) => {
          part.setPointerCapture(event.pointerId);
          dot.focus();
          event.preventDefault();
        });
        part.addEventListener("pointermove", (event) => {
          if (!part.hasPointerCapture(event.pointerId)) return;
          const box = this.svg.getBoundingClientRect();
          const wide = (this.x[1] - this.x[0]) / box.width;
          move([this.x[0] + (event.clientX - box.left) * wide, this.y[1] - (event.clientY - box.top) * wide]);
        });
      }
      const keys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      dot.addEventListener("keydown", (event) => {
        const way = keys[event.key];
        if (!way) return;
        event.preventDefault();
        const step = STEP * (this.x[1] - this.x[0]);
        move([point.at[0] + step * way[0], point.at[1] + step * way[1]]);
      });
      point.place = () => {
        const [cx, cy] = this.pixel(point.at);
        for (const part of [dot, reach]) {
          part.setAttribute("cx", cx);
          part.setAttribute("cy", cy);
        }
      };
      point.move = move;
      (this.points ??= []).push(point);
      return point;
    }

    slider(name, from, to, step, start) {
      const label = this.controls.appendChild(document.createElement("label"));
      const words = label.appendChild(document.createElement("span"));
      const input = label.appendChild(document.createElement("input"));
      Object.assign(input, { type: "range", min: from, max: to, step, value: start });
      input.setAttribute("aria-label", name);
      const digits = (String(step).split(".")[1] ?? "").length;
      const tell = () => (words.textContent = `${name} ${Number(input.value).toFixed(digits)}`);
      input.addEventListener("input", () => (tell(), this.moved()));
      tell();
      return () => Number(input.value);
    }

    button(name, pressed) {
      const made = this.controls.appendChild(document.createElement("button"));
      made.type = "button";
      made.textContent = name;
      made.addEventListener("click", () => (pressed(), this.moved()));
    }

    run(draw) {
      this.moved = () => {
        this.drawn.replaceChildren();
        const { result, english, chinese } = draw();
        this.points.forEach((point) => point.place());
        this.sentence.textContent = this.say(english, chinese);
        this.place.dataset.result = JSON.stringify(result);
      };
      this.moved();
    }
  }

  window.Figures.Stage = Stage;
  document.addEventListener("DOMContentLoaded", () => {
    for (const place of document.querySelectorAll("[data-figure]")) window.Figures.start[place.dataset.figure](place);
  });
})();
