// Two feet in a plane, each on ground of its own slope: where may the centre of mass be?
"use strict";

window.Figures.start.region = (place) => {
  const stage = new window.Figures.Stage(place, [-1.3, 1.3], [-0.35, 1.25]);
  const feet = [
    stage.handle(stage.say("left foot", "左足"), [-0.6, 0.1]),
    stage.handle(stage.say("right foot", "右足"), [0.6, 0.1]),
  ];
  const centre = stage.handle(stage.say("centre of mass", "质心"), [0.1, 0.9]);
  const slopes = [
    stage.slider(stage.say("left ground °", "左侧地面 °"), -90, 90, 1, 0),
    stage.slider(stage.say("right ground °", "右侧地面 °"), -90, 90, 1, 0),
  ];
  const mu = stage.slider("μ", 0.05, 1, 0.05, 0.6);
  const TINY = 1e-9;
  const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

  // Forces are c >= 0 along four rays. They carry a weight of 1 at x where they add up to (0, 1) with the moment x: a
  // linear program in the plane, whose corners are pairs of rays and whose directions to infinity are triples.
  function span(rays) {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < 4; i++)
      for (let j = i + 1; j < 4; j++) {
        const area = cross(rays[i].way, rays[j].way);
        if (Math.abs(area) < TINY) continue;
        const [a, b] = [cross([0, 1], rays[j].way) / area, cross(rays[i].way, [0, 1]) / area];
        if (a < -TINY || b < -TINY) continue;
        const x = a * rays[i].moment + b * rays[j].moment;
        [low, high] = [Math.min(low, x), Math.max(high, x)];
      }
    if (low > high) return null;
    for (let left = 0; left < 4; left++) {
      const [p, q, r] = rays.filter((_, i) => i !== left);
      let shares = [cross(q.way, r.way), cross(r.way, p.way), cross(p.way, q.way)];
      if (shares.every((c) => c <= TINY)) shares = shares.map((c) => -c);
      if (shares.some((c) => c < -TINY) || shares.every((c) => c < TINY)) continue;
      const moment = shares[0] * p.moment + shares[1] * q.moment + shares[2] * r.moment;
      if (moment > TINY) high = Infinity;
      if (moment < -TINY) low = -Infinity;
    }
    return [low, high];
  }

  stage.run(() => {
    const angles = slopes.map((slope) => (slope() * Math.PI) / 180);
    const rays = feet.flatMap(({ at }, i) =>
      [-1, 1].map((side) => {
        const lean = angles[i] - side * Math.atan(mu());
        const way = [-Math.sin(lean), Math.cos(lean)];
        return { at, way, moment: cross(at, way) };
      }));
    const found = span(rays);
    const [low, high] = found ?? [NaN, NaN];
    const ends = [Math.max(low, stage.x[0]), Math.min(high, stage.x[1])];
    if (found) stage.line([[ends[0], -0.35], [ends[1], -0.35], [ends[1], 1.25], [ends[0], 1.25]], "region", true);
    feet.forEach(({ at }, i) => {
      const along = [0.3 * Math.cos(angles[i]), 0.3 * Math.sin(angles[i])];
      stage.line([[at[0] - along[0], at[1] - along[1]], [at[0] + along[0], at[1] + along[1]]], "ground");
      const tips = rays.slice(2 * i, 2 * i + 2).map(({ way }) => [at[0] + 0.4 * way[0], at[1] + 0.4 * way[1]]);
      stage.line([at, ...tips], "exact", true);
      stage.line([at, centre.at], "body");
    });
    const x = centre.at[0];
    const stands = found !== null && x >= low && x <= high;
    stage.line([[x, -0.35], [x, 1.25]], stands ? "plumb" : "plumb bad");
    const between = x >= Math.min(feet[0].at[0], feet[1].at[0]) && x <= Math.max(feet[0].at[0], feet[1].at[0]);
    const result = {
      feet: feet.map(({ at }) => at), centre: centre.at, angles, mu: mu(), stands,
      low: Number.isFinite(low) ? low : String(low), high: Number.isFinite(high) ? high : String(high),
    };
    const end = (value, english, chinese) => (Number.isFinite(value) ? value.toFixed(2) : stage.say(english, chinese));
    const interval = found ? `[${end(low, "no end", "无界")}, ${end(high, "no end", "无界")}]` : "";
    return {
      result,
      english: !found ? "No place of the centre of mass can be held: the cones cannot carry the weight."
        : `${stands ? "It can stand" : "It cannot stand"}: x = ${x.toFixed(2)} m, the region is ${interval} m`
          + (stands === between ? "." : stands ? ", wider than the feet." : ", narrower than the feet.") + " How high the centre of mass is changes nothing.",
      chinese: !found ? "质心放在哪里都站不住：两个摩擦锥托不起重量。"
        : `${stands ? "能站住" : "站不住"}：x = ${x.toFixed(2)} m，支撑区域为 ${interval} m`
          + (stands === between ? "。" : stands ? "，比两足之间更宽。" : "，比两足之间更窄。") + "质心的高低不改变结果。",
    };
  });
};
