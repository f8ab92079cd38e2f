// A linear complementarity problem of two contacts: w = A z + q, w >= 0, z >= 0, w z = 0. In the plane of q each
// mode is a cone; where one covers q, it is a solution.
"use strict";

window.Figures.start.lcp = (place) => {
  const stage = new window.Figures.Stage(place, [-2, 1.6], [-1.9, 1.5]);
  const columns = [
    stage.handle(stage.say("-A₁: what contact 1 does", "-A₁：接触 1 的作用"), [-1, -0.4]),
    stage.handle(stage.say("-A₂: what contact 2 does", "-A₂：接触 2 的作用"), [-0.4, -1]),
  ];
  const q = stage.handle(stage.say("q: approach of both contacts", "q：两个接触的接近速度"), [-0.9, 0.3]);
  const NAMES = [["both open", "都张开"], ["1 closed, 2 opens", "1 闭合，2 张开"], ["2 closed, 1 opens", "2 闭合，1 张开"], ["both closed", "都闭合"]];
  const FAR = 6; // how long a cone is drawn
  const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

  stage.run(() => {
    const unit = [[1, 0], [0, 1]];
    const solutions = [];
    for (let mode = 0; mode < 4; mode++) {
      const closed = [Boolean(mode & 1), Boolean(mode & 2)];
      const basis = [0, 1].map((i) => (closed[i] ? columns[i].at : unit[i]));
      const area = cross(...basis);
      const ends = basis.map((way) => way.map((value) => (FAR * value) / Math.max(Math.hypot(...way), 1e-9)));
      const between = [ends[0][0] + ends[1][0], ends[0][1] + ends[1][1]];
      stage.line([[0, 0], ends[0], between, ends[1]], `mode mode-${mode}`, true);
      if (Math.abs(area) < 1e-9) continue;
      const share = [cross(q.at, basis[1]) / area, cross(basis[0], q.at) / area];
      if (share.some((value) => value < -1e-12)) continue;
      solutions.push({ mode, z: share.map((value, i) => (closed[i] ? value : 0)), w: share.map((value, i) => (closed[i] ? 0 : value)) });
    }
    const A = [0, 1].map((row) => columns.map(({ at }) => -at[row]));
    const always = A[0][0] > 0 && A[1][1] > 0 && A[0][0] * A[1][1] - A[0][1] * A[1][0] > 0;
    unit.forEach((way, i) => {
      stage.arrow([0, 0], way, "axis");
      stage.text([1.06 * way[0] + 0.03, 1.06 * way[1] + 0.03], `e${"₁₂"[i]}`);
    });
    columns.forEach(({ at }, i) => {
      stage.arrow([0, 0], at, "force");
      stage.text([at[0] - 0.28, at[1] - 0.14], `-A${"₁₂"[i]}`);
    });
    stage.arrow([0, 0], q.at, "push");
    stage.text([q.at[0] + 0.08, q.at[1] + 0.08], "q");
    const told = solutions.map(({ mode, z }) => `${stage.say(...NAMES[mode])} (z = ${z.map((value) => value.toFixed(2)).join(", ")})`);
    return {
      result: { A, q: q.at, solutions, always },
      english: `${["No solution", "One solution", "Two solutions", "Three solutions", "Four solutions"][solutions.length]}${told.length ? `: ${told.join("; ")}.` : "."} `
        + (always ? "All principal minors of A are positive: the four cones tile the plane, each q has one solution." : "A principal minor of A is not positive: cones overlap or leave gaps."),
      chinese: `${solutions.length} 个解${told.length ? `：${told.join("；")}。` : "。"}`
        + (always ? "A 的主子式全为正：四个锥铺满平面，每个 q 恰有一个解。" : "A 有主子式不为正：锥有重叠或空隙。"),
    };
  });
};
