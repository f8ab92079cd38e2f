// A block of 1 kg on a slope, pushed: does it stick, slide or lift off?
"use strict";

window.Figures.start.block = (place) => {
  const stage = new window.Figures.Stage(place, [-0.35, 1.85], [-0.45, 1.3]);
  const G = 9.81; // m/s^2
  const PER_NEWTON = 0.035; // length of arrows
  const LENGTH = 1.6;
  const circle = ([x, y]) => {
    const angle = Math.min(Math.max(Math.atan2(y, x), 0), 1.2);
    return [LENGTH * Math.cos(angle), LENGTH * Math.sin(angle)];
  };
  const top = stage.handle(stage.say("end of the slope", "斜面的端点"), [1.5, 0.55], circle);
  const push = stage.handle(stage.say("push", "推力"), [1.0, 0.36]);
  const mu = stage.slider("μ", 0, 1, 0.05, 0.5);
  let before = top.at;

  stage.run(() => {
    const angle = Math.atan2(top.at[1], top.at[0]);
    const [along, normal] = [[Math.cos(angle), Math.sin(angle)], [-Math.sin(angle), Math.cos(angle)]];
    const middle = [top.at[0] / 2, top.at[1] / 2];
    if (before !== top.at) push.at = [0, 1].map((i) => push.at[i] + (top.at[i] - before[i]) / 2); // the push stays as it is
    before = top.at;
    const pushed = [0, 1].map((i) => (push.at[i] - middle[i]) / PER_NEWTON);
    const load = [pushed[0], pushed[1] - G];
    const [t, n] = [along, normal].map((axis) => axis[0] * load[0] + axis[1] * load[1]);
    const most = mu() * Math.max(-n, 0);
    const mode = n > 0 ? "lifts" : Math.abs(t) <= most ? "sticks" : "slides";
    const force = mode === "lifts" ? [0, 0] : [mode === "sticks" ? -t : -Math.sign(t) * most, -n];
    const acceleration = [t + force[0], n + force[1]];
    const place = (a, b) => [0, 1].map((i) => middle[i] + a * along[i] + b * normal[i]);

    stage.line([[0, 0], top.at], "ground");
    const reach = 16 * PER_NEWTON;
    if (mu() > 0) stage.line([middle, place(mu() * reach, reach), place(-mu() * reach, reach)], "exact", true);
    stage.line([place(-0.13, 0), place(0.13, 0), place(0.13, 0.16), place(-0.13, 0.16)], "body", true);
    stage.arrow(middle, [middle[0], middle[1] - G * PER_NEWTON], "weight");
    stage.arrow(middle, push.at, "push");
    stage.arrow(middle, place(force[0] * PER_NEWTON, force[1] * PER_NEWTON), mode === "sticks" ? "force" : "force bad");
    const degrees = ((angle * 180) / Math.PI).toFixed(1);
    const rate = Math.hypot(...acceleration).toFixed(2);
    const [english, chinese] = {
      sticks: [`It sticks: of ${most.toFixed(1)} N of friction it uses ${Math.abs(t).toFixed(1)} N.`, `粘住：可用摩擦 ${most.toFixed(1)} N，用去 ${Math.abs(t).toFixed(1)} N。`],
      slides: [`It slides ${t > 0 ? "up" : "down"} the slope with ${rate} m/s²: friction is at its limit of ${most.toFixed(1)} N and opposes it.`, `沿斜面${t > 0 ? "向上" : "向下"}滑动，加速度 ${rate} m/s²：摩擦已到极限 ${most.toFixed(1)} N，与滑动方向相反。`],
      lifts: [`It lifts off with ${rate} m/s²: the ground does not pull.`, `离地，加速度 ${rate} m/s²：地面不会拉住它。`],
    }[mode];
    return {
      result: { angle, mu: mu(), push: pushed, load: [t, n], mode, force, acceleration },
      english: `${english} The slope has ${degrees}°, alone it would hold up to ${((Math.atan(mu()) * 180) / Math.PI).toFixed(1)}°.`,
      chinese: `${chinese}斜面 ${degrees}°；没有推力时最多 ${((Math.atan(mu()) * 180) / Math.PI).toFixed(1)}° 不滑。`,
    };
  });
};
