// A cat of three rods in the air, without angular momentum: shape on the left, the body that turns on the right.
"use strict";

window.Figures.start.cat = (place) => {
  const stage = new window.Figures.Stage(place, [-1.2, 3.6], [-1.2, 1.2]);
  const SPAN = 2.4; // rad of each joint at the square's edge
  const ROD = 0.6; // length; each rod has the mass 1
  const STEP = 0.02; // rad between two evaluations of the connection
  const HOME = [0, 0];
  const shape = stage.handle(stage.say("shape: bend of both joints", "形状：两个关节的弯曲"), HOME, (wish) =>
    wish.map((value) => Math.min(Math.max(value, -1), 1)));
  let [path, turn] = [[[0, 0]], 0];
  stage.button(stage.say("start anew", "重新开始"), () => {
    shape.at = HOME;
    [path, turn] = [[[0, 0]], 0];
  });

  const along = (angle, length) => [length * Math.cos(angle), length * Math.sin(angle)];
  const rods = ([a, b], theta) => {
    const [h, front, back] = [ROD / 2, theta + a, theta + b];
    const [body, one, two] = [along(theta, h), along(front, h), along(back, h)];
    const middles = [[0, 0], [-body[0] - one[0], -body[1] - one[1]], [body[0] + two[0], body[1] + two[1]]];
    const common = [0, 1].map((i) => (middles[0][i] + middles[1][i] + middles[2][i]) / 3);
    return { angles: [theta, front, back], middles: middles.map((p) => [p[0] - common[0], p[1] - common[1]]) };
  };
  // Angular momentum for rates of the body and of both joints, in a given shape.
  const momentum = ([a, b], [body, da, db]) => {
    const h = ROD / 2;
    const [front, back] = [body + da, body + db];
    const speed = (angle, rate) => [-h * Math.sin(angle) * rate, h * Math.cos(angle) * rate];
    const [v0, v1, v2] = [speed(0, body), speed(a, front), speed(b, back)];
    const speeds = [[0, 0], [-v0[0] - v1[0], -v0[1] - v1[1]], [v0[0] + v2[0], v0[1] + v2[1]]];
    const spin = ((body + front + back) * ROD * ROD) / 12; // of each rod about its own middle
    return rods([a, b], 0).middles.reduce((sum, p, i) => sum + p[0] * speeds[i][1] - p[1] * speeds[i][0], spin);
  };

  function follow(to) {
    const from = path[path.length - 1];
    const count = Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / STEP);
    if (!count) return;
    const [da, db] = [(to[0] - from[0]) / count, (to[1] - from[1]) / count];
    for (let i = 0; i < count; i++) {
      const middle = [from[0] + (i + 0.5) * da, from[1] + (i + 0.5) * db];
      turn -= momentum(middle, [0, da, db]) / momentum(middle, [1, 0, 0]);
    }
    path.push(to);
  }

  stage.run(() => {
    follow(shape.at.map((value) => value * SPAN));
    stage.line([[-1, -1], [1, -1], [1, 1], [-1, 1]], "frame", true);
    stage.line([[-1, 0], [1, 0]], "frame");
    stage.line([[0, -1], [0, 1]], "frame");
    stage.line(path.map((point) => point.map((value) => value / SPAN)), "push");
    const bent = path[path.length - 1];
    const { angles, middles } = rods(bent, turn);
    angles.forEach((angle, i) => {
      const [dx, dy] = along(angle, ROD / 2);
      const [x, y] = [middles[i][0] + 2.4, middles[i][1]];
      stage.line([[x - dx, y - dy], [x + dx, y + dy]], i ? "limb" : "limb middle");
    });
    const [dx, dy] = along(turn, 1);
    stage.line([[2.4 - dx, -dy], [2.4 + dx, dy]], "plumb");
    const degrees = ((turn * 180) / Math.PI).toFixed(1);
    return {
      result: { shape: bent, turn, path },
      english: `The middle has turned by ${degrees}°, with no angular momentum at any instant. Drag a loop and come back to the centre: the shape is as it was, the turn stays; the loop backwards undoes it.`,
      chinese: `中段已转过 ${degrees}°，其间角动量始终为零。拖出一个闭合回路再回到中心：形状复原，转角却留下；反向走同一回路则抵消。`,
    };
  });
};
