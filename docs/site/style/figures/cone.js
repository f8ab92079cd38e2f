// The section of a friction cone at a normal force of 1, with the pyramids of k sides inside and around it.
"use strict";

window.Figures.start.cone = (place) => {
  const stage = new window.Figures.Stage(place, [-1.5, 1.5], [-1.05, 1.05]);
  const force = stage.handle(stage.say("tangential force", "切向力"), [0.42, 0.3]);
  const mu = stage.slider("μ", 0.1, 0.7, 0.05, 0.6);
  const sides = stage.slider(stage.say("sides", "边数"), 4, 16, 1, 4);

  const corners = (count, radius) =>
    Array.from({ length: count }, (_, i) => (2 * Math.PI * i) / count).map((a) => [radius * Math.cos(a), radius * Math.sin(a)]);
  // The largest step along a side's normal decides: sides look halfway between corners.
  const inside = (count, radius) => {
    const normals = Array.from({ length: count }, (_, i) => (Math.PI * (2 * i + 1)) / count);
    const reach = Math.max(...normals.map((a) => force.at[0] * Math.cos(a) + force.at[1] * Math.sin(a)));
    return reach <= radius * Math.cos(Math.PI / count);
  };

  stage.run(() => {
    const [m, k] = [mu(), sides()];
    const around = m / Math.cos(Math.PI / k);
    const used = Math.hypot(...force.at) / m;
    stage.line(corners(k, around), "outer", true);
    stage.circle([0, 0], m, "exact");
    stage.line(corners(k, m), "inner", true);
    stage.arrow([0, 0], force.at, used <= 1 ? "force" : "force bad");
    const result = {
      mu: m, sides: k, force: force.at, used, circle: used <= 1, inner: inside(k, m), outer: inside(k, around),
      gives_up: 1 - Math.cos(Math.PI / k), overshoots: 1 / Math.cos(Math.PI / k) - 1,
    };
    const percent = (share) => (100 * share).toFixed(1);
    const english = used > 1
      ? `It slides: ${percent(used)} % of the friction there is.` + (result.outer ? " The outer pyramid promises that it holds." : " The outer pyramid refuses it, too.")
      : `It holds, with ${percent(used)} % of the friction.` + (result.inner ? " The inner pyramid grants it." : " The inner pyramid refuses it.");
    const chinese = used > 1
      ? `会打滑：需要现有摩擦的 ${percent(used)} %。` + (result.outer ? "外切棱锥却许诺它能保持。" : "外切棱锥同样拒绝它。")
      : `能保持，用去摩擦的 ${percent(used)} %。` + (result.inner ? "内接棱锥也允许它。" : "内接棱锥却拒绝它。");
    return {
      result,
      english: `${english} With ${k} sides the inner one gives up ${percent(result.gives_up)} % at worst, the outer one overshoots by ${percent(result.overshoots)} %.`,
      chinese: `${chinese}${k} 边时，内接最多放弃 ${percent(result.gives_up)} %，外切最多多出 ${percent(result.overshoots)} %。`,
    };
  });
};
