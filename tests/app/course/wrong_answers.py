"""Wrong answers of the usual kind: what students write, as a change of the solution."""

from __future__ import annotations

from typing import NamedTuple

WRONG: dict[str, dict[str, tuple[str, str]]] = {
    "52.1.1": {
        "a box, √2 on its diagonal": ("float(np.linalg.norm(force - pressing * normal))", "float(np.abs(force - pressing * normal).max())"),
        "the normal points into the ground": ("normal = np.array([-np.sin(angle), 0.0, np.cos(angle)])", "normal = -np.array([-np.sin(angle), 0.0, np.cos(angle)])"),
        "world axes": ("[-np.sin(angle), 0.0, np.cos(angle)]", "[0.0, 0.0, 1.0]"),
        "the slope falls": ("[-np.sin(angle)", "[np.sin(angle)"),
        "sine in place of tangent": ("np.tan(", "np.sin("),
        "degrees": ("np.tan(np.radians(slope))", "np.tan(slope)"),
        "a pull is allowed": ("pressing >= 0.0 and tangential <= mu * pressing", "tangential <= mu * abs(pressing)"),
    },
    "52.1.2": {
        "the force's sign": ("in_normal_cone(-force, gap)", "in_normal_cone(force, gap)"),
        "a product alone": ("gap - np.maximum(0.0, gap - r * force)", "gap * force"),
        "r left out of the sign": ("gap - r * force)", "gap + r * force)"),
        "half a line in the air": ("direction == 0.0 if gap > 0.0 else direction <= 0.0", "direction <= 0.0"),
        "not empty in penetration": ("    if gap < 0.0:\n        return False\n", ""),
    },
    "52.1.3": {
        "mass sinks deeper": ("(1.0 - impedance) * 9.81 *", "9.81 *"),
        "the deepest is the largest gap": ("max(0.0, -gaps.min())", "max(0.0, gaps.max())"),
        "products that cancel": ("np.abs(gaps * forces).max()", "(gaps * forces).sum()"),
        "two of three": ("all(error <= tol for error in signorini_errors(gaps, forces))", "all(e <= tol for e in signorini_errors(gaps, forces)[:2])"),
    },
    "52.2.1": {
        "inner and outer exchanged": ('== "inner"', '== "outer"'),
        "outer corners on the circle": ("mu / np.cos(np.pi / k)", "mu"),
        "rows of the other pyramid": ('np.cos(np.pi / k) if fit == "inner" else mu', "1.0"),
        "7.6 % for outer": ("1.0 / np.cos(np.pi / k) - 1.0,", "1.0 - np.cos(np.pi / k),"),
        "radius for area": ("k * np.tan(np.pi / k) / np.pi - 1.0", "1.0 / np.cos(np.pi / k) - 1.0"),
    },
    "52.2.2": {
        "friction over √2": ("[sign, 0, -mu, 0, 0, 0], [0, sign, -mu, 0, 0, 0]", "[sign, 0, -mu / np.sqrt(2), 0, 0, 0], [0, sign, -mu / np.sqrt(2), 0, 0, 0]"),
        "no yaw rows": ("for turn, s, t in itertools.product((1.0, -1.0), repeat=3):", "for turn, s, t in ():"),
        "yaw uncoupled": ("[s * half_y, t * half_x, -mu * (half_x + half_y), turn * s * mu, turn * t * mu, turn]", "[0, 0, -mu * (half_x + half_y), 0, 0, turn]"),
        "length for width": ("[0, 0, -half_y, sign, 0, 0], [0, 0, -half_x, 0, sign, 0]", "[0, 0, -half_x, sign, 0, 0], [0, 0, -half_y, 0, sign, 0]"),
        "moment before force": ("[sign, 0, -mu, 0, 0, 0], [0, sign, -mu, 0, 0, 0]", "[0, 0, 0, sign, 0, -mu], [0, 0, 0, 0, sign, -mu]"),
        "the centre's sign": ("[-wrench[4], wrench[3]]", "[wrench[4], -wrench[3]]"),
        "an inequality is never tight": ("np.abs(rows @ wrench) <= 1e-6 * abs(wrench[2])", "np.zeros(len(rows), dtype=bool)"),
    },
    "52.2.3": {
        "the regularisation's sign": ("+ reg)\n\n\ndef gradient", "- reg)\n\n\ndef gradient"),
        "gripper outside of mu": ("mu * (force[2] + gripper)", "mu * force[2] + gripper"),
        "the gradient's sign": ("[-force[0] / root, -force[1] / root, mu]", "[force[0] / root, force[1] / root, mu]"),
        "the hessian without regularisation": ("[[y * y + reg, -x * y], [-x * y, x * x + reg]]", "[[y * y, -x * y], [-x * y, x * x]]"),
    },
    "52.3.1": {
        "2 eps under the root": ("+ eps * eps)\n\n\ndef gradient", "+ 2.0 * eps)\n\n\ndef gradient"),
        "the sign": ("return a + b - np.sqrt", "return np.sqrt(a * a + b * b + eps * eps) - a - b\n    return a + b - np.sqrt"),
        "0 / 0": ("    if root == 0.0:\n        return 1.0 - np.sqrt(0.5), 1.0 - np.sqrt(0.5)\n", ""),
        "a b = eps²": ("eps * eps / (2.0 * a)", "eps * eps / a"),
    },
    "52.3.2": {
        "it bounces": ("-mass * (z / dt + free)", "-2.0 * mass * (z / dt + free)"),
        "no dynamics": ("out.append((z, v, impulse))", "out.append((height, 0.0, 0.0))"),
        "force once it is below": ("-mass * (z / dt + free)", "-mass * free if z <= 0.0 else 0.0"),
        "explicit": ("z = z + dt * v\n", "z = z + dt * (v - 9.81 * dt)\n"),
        "no gravity after touchdown": ("free = v - 9.81 * dt", "free = v - 9.81 * dt * (z > 0.0)"),
    },
    "52.3.3": {
        "eps, not its square": ("eps * eps / 2.0)", "eps)"),
        "the other root": ("(root - a) / (2.0 * c)", "(-root - a) / (2.0 * c)"),
        "the band ends at the law": ("max(0.0, -a / c), barrier(a, c, eps)", "max(0.0, -a / c), max(0.0, -a / c)"),
        "starts hard": ("out = [start]", "out = [end / 2.0]"),
        "one too few": ("out[-1] >= end", "out[-1] >= 2.0 * end"),
    },
    "52.4.1": {
        "absolute angles": ("total = np.cumsum(angles)\n    return np.array", "total = angles\n    return np.array"),
        "own link alone": ("np.cumsum(steps[:, ::-1], axis=1)[:, ::-1]", "steps"),
        "the moment's sign": ("jacobian(lengths, angles).T @ force", "-jacobian(lengths, angles).T @ force"),
    },
    "52.4.2": {
        "LOCAL left as it is": ("np.vstack([R @ local[:3], R @ local[3:]])", "local"),
        "the transpose": ("np.vstack([R @ local[:3], R @ local[3:]])", "np.vstack([R.T @ local[:3], R.T @ local[3:]])"),
        "the linear rows alone": ("np.vstack([R @ local[:3], R @ local[3:]])", "np.vstack([R @ local[:3], local[3:]])"),
        "no reference point": ("linear + np.cross(p, angular, axisb=0, axisc=0)", "linear"),
        "the cross product's sign": ("linear + np.cross", "linear - np.cross"),
        "local with world forces": ("aligned(local, R)[:3].T @ force", "local[:3].T @ force"),
    },
    "52.4.3": {
        "damping in the mass": ("inverse = np.linalg.solve(M, J.T)", "inverse = np.linalg.solve(M + damping * np.eye(len(M)), J.T)"),
        "always a little": ("+ damping * np.eye", "+ (damping + 1e-3) * np.eye"),
        "the force's sign": ("-J @ free)", "J @ free)"),
        "always needed": ("bool(np.linalg.matrix_rank(J) < len(J))", "True"),
        "never needed": ("bool(np.linalg.matrix_rank(J) < len(J))", "False"),
    },
    "52.5.1": {
        "m 1 in base axes": ('mass * R if axes == "local" else mass * np.eye(3)', "mass * np.eye(3)"),
        "about the base": ("positions - centre", "positions"),
        "the offset's sign": ("-mass * _cross(centre)", "mass * _cross(centre)"),
        "world like base": ('turn @ local if axes == "local" else turn @ local @ turn.T', "turn @ local"),
    },
    "52.5.2": {
        "about the origin": ("positions - centre", "positions"),
        "points alone": ("out += own + m", "out += m"),
        "no parallel axes": ("own + m * (x @ x * np.eye(3) - np.outer(x, x))", "own"),
        "a plain mean": ("masses @ positions / masses.sum()", "positions.mean(axis=0)"),
    },
    "52.5.3": {
        "about the origin": ("points - com", "points"),
        "no gravity": ("-9.81]", "0.0]"),
        "gravity has a moment": ("np.cross(points - com, forces).sum(axis=0)]", "np.cross(points - com, forces).sum(axis=0) + np.cross(com, [0.0, 0.0, -9.81 * mass])]"),
        "moment first": ("np.r_[linear, np.cross(points - com, forces).sum(axis=0)]", "np.r_[np.cross(points - com, forces).sum(axis=0), linear]"),
    },
    "52.6.1": {
        "conserved, so it cannot pitch": ("-legs / (trunk + legs) * (leg_angles[-1] - leg_angles[0])", "0.0"),
        "over the trunk alone": ("-legs / (trunk + legs)", "-legs / trunk"),
        "with the legs": ("return -legs / (trunk", "return legs / (trunk"),
        "the leg's rate in the world": ("legs * (pitch_rate + leg_rate)", "legs * leg_rate"),
        "no root": ("np.sqrt(2.0 * height / 9.81)", "2.0 * height / 9.81"),
    },
    "52.6.2": {
        "over the trunk alone": ("-middle / (trunk + middle)", "-middle / trunk"),
        "zero momentum, so no turn": ("return float(np.sum(-middle / (trunk + middle) * np.diff(angle)))", "return 0.0"),
        "one joint": ("(large, -reach), (large, reach)", "(small, -reach), (small, reach)"),
        "the wrong way round": ("reach = -angle", "reach = angle"),
        "a swing too wide": ("int(np.ceil(abs(angle) / (2.0 * swing * per_radian)))", "1"),
        "not closed": ("np.array(loop * loops + [loop[0]])", "np.array(loop * loops)"),
    },
    "52.6.3": {
        "arms with the legs": ("return -leg_mass * hip", "return leg_mass * hip"),
        "no lever arms": ("leg_mass * hip * leg_speed / (arm_mass * shoulder)", "leg_mass * leg_speed / arm_mass"),
        "about the origin": ("positions - centre, velocities - speed", "positions, velocities"),
        "pitch for yaw": ("np.array([1.0, -1.0, 1.0, -1.0]) * half_width", "np.array([1.0, 1.0, -1.0, -1.0]) * half_width"),
    },
    "52.7.1": {
        "the normal's sign in the rows": ("-mu * np.cos(np.pi / k)", "mu * np.cos(np.pi / k)"),
        "the outer pyramid": ("-mu * np.cos(np.pi / k)", "-mu / np.cos(np.pi / k)"),
        "no pyramids": ('{"type": "ineq", "fun": lambda x: -rows @ x, "jac": lambda x: -rows},', ""),
        "moments about the origin": ("grasp[3:] = np.hstack([np.cross(p - com, np.eye(3)).T for p in feet])", "grasp[3:] = np.hstack([np.cross(p, np.eye(3)).T for p in feet])"),
        "internal forces": ("return scale * found.x.reshape(n, 3)", "found.x[:6] += np.r_[feet[1] - feet[0], feet[0] - feet[1]]\n    return scale * found.x.reshape(n, 3)"),
        "the largest force is closest": ("np.argmax(use(forces, mu))", "np.argmax(np.linalg.norm(forces, axis=1))"),
    },
    "52.7.2": {
        "a loose tolerance": ("< 1e-10", "< 1e-2"),
        "inequalities alone": ("max(np.abs(A @ x - b).max(initial=0.0), ", "max(0.0, "),
        "equalities alone": ("return x\n", "return np.linalg.solve(np.block([[P, A.T], [A, np.zeros((m, m))]]), np.r_[-q, b])[:n]\n"),
        "room counts as violation": ("(C @ x - d).max(initial=0.0)", "np.abs(C @ x - d).max(initial=0.0)"),
    },
    "52.8.1": {
        "no damping ratio": ("1.0 / (impedance * (timeconst * dampratio) ** 2)", "1.0 / (impedance * timeconst**2)"),
        "half the damping": ("2.0 / (impedance * timeconst)", "1.0 / (impedance * timeconst)"),
        "impedance twice": ("(1.0 - impedance) * 9.81", "(1.0 - impedance) / impedance * 9.81"),
        "always oscillates": ("    if dampratio >= 1.0:\n        return 0.0\n", "    dampratio = min(dampratio, 0.99) / 2.0\n"),
        "one step": ("2.0 * dt", "dt"),
    },
    "52.8.2": {
        "a half size for a size": ("1.0 + 3.0 * cop[0]", "1.0 + 6.0 * cop[0]"),
        "the same everywhere": ("mean * (1.0 + 3.0 * cop[0] * x / half_x**2 + 3.0 * cop[1] * y / half_y**2)", "mean"),
        "the whole rectangle": ("<= 1.0 / 3.0", "<= 1.0"),
        "one split": ("one + min(one[1], one[2])", "one + 0.0"),
        "a corner pulls": ("min(one[1], one[2])", "2.0 * max(one[1], one[2])"),
    },
    "52.9.1": {
        "any difference": ("< 0.03", "< 1.1"),
        "a fixed threshold": ("return bool(np.mean(chance", "return bool(abs(np.mean(low) - np.mean(high)) > 1.0)\n    return bool(np.mean(chance"),
        "one direction": (">= abs(np.mean(low) - np.mean(high))", ">= np.mean(low) - np.mean(high)"),
        "swing counts": ("step[loaded[1:] & loaded[:-1]].sum()", "step.sum()"),
        "feet in the air": ("forces[forces[:, 2] >= 1.0]", "forces"),
        "heights count": ("positions[:, :, :2]", "positions"),
    },
    "52.9.2": {
        "A first, then B": ('"".join("AB" if k else "BA" for k in first)', '"A" * pairs + "B" * pairs'),
        "always A before B": ('"".join("AB" if k else "BA" for k in first)', '"AB" * pairs'),
        "one group's spread": ("np.ceil(2.0 *", "np.ceil("),
        "one-sided": ("np.abs(signs @ difference) / n", "signs @ difference / n"),
        "level not halved": ("1.0 - level / 2.0", "1.0 - level"),
        "pairs by rank": ("difference = np.asarray(a) - np.asarray(b)", "difference = np.sort(a) - np.sort(b)"),
    },
}  # fmt: skip
"""Exercise to its wrong answers: a name, and what of the solution is written how instead."""


class Narrow(NamedTuple):
    """A wrong answer: what of the solution is written how instead, and what is said by which property."""

    number: str
    property: str
    old: str
    new: str
    words: str


_CORNERS = "    return reach * np.column_stack"
_PYRAMID = "    return np.column_stack([np.cos(middle), np.sin(middle), np.full(k, -distance)])\n"
_SOLE = "    return np.array(rows)\n"
_VALUE = "    return mu * (force[2] + gripper) - np.sqrt(force[0] ** 2 + force[1] ** 2 + reg)\n"

PYRAMIDS = (
    Narrow("52.2.1", "corners of the inner", _CORNERS, "    reach = reach * 1.0001\n" + _CORNERS, "the corners' distance"),
    Narrow("52.2.1", "corners of the inner", _CORNERS, "    angle = 2.0 * np.pi * (np.arange(k) / k) ** 1.1\n" + _CORNERS, "the sides' distance"),
    Narrow("52.2.1", "corners of the inner", "angle = 2.0 * np.pi * np.arange(k) / k", "angle = 4.0 * np.pi * np.arange(k) / k", "the area is"),
    Narrow("52.2.1", "corners of the inner", _CORNERS, "    angle = 0.0 * angle\n" + _CORNERS, "corners coincide"),
    Narrow("52.2.1", "corners of the inner", _CORNERS, "    angle = np.where(angle == angle[1], 0.0, angle)\n" + _CORNERS, "corners coincide"),
    Narrow("52.2.1", "sides of the outer", _CORNERS, "    reach = reach * 1.0001\n" + _CORNERS, "the sides' distance from the middle"),
    Narrow("52.2.1", "sides of the outer", _CORNERS, "    if k % 2:\n        angle, reach = 2.0 * angle, mu / np.cos(2.0 * np.pi / k)\n" + _CORNERS, "the area is"),
    Narrow("52.2.1", "rows and corners", _PYRAMID, "    distance *= 0.999\n" + _PYRAMID, "a corner is outside by"),
    Narrow("52.2.1", "rows and corners", _PYRAMID, "    distance *= 1.001\n" + _PYRAMID, "sides, expected two each"),
    Narrow("52.2.1", "rows and corners", _PYRAMID, "    return np.zeros((k, 3))\n", "sides, expected two each"),
    Narrow("52.2.1", "inner forces are in the cone", "else mu\n    return", "else 0.9 * mu\n    return", "the outer pyramid refuses"),
    Narrow("52.2.1", "inner forces are in the cone", "mu * np.cos(np.pi / k) if", "1.01 * mu if", "the inner pyramid admits"),
    Narrow("52.2.1", "the errors are those", "np.cos(np.pi / k) - 1.0,", "1.0 - np.cos(np.pi / k),", "(worst direction, area)"),
    Narrow("52.2.1", "the errors are those", "k * np.tan(np.pi / k) / np.pi - 1.0", "1.0 - k * np.tan(np.pi / k) / np.pi", "(worst direction, area)"),
)  # fmt: skip

SOLES = (
    Narrow("52.2.2", "whatever four corners", _SOLE, "    return np.array(rows)[:, :5]\n", "expected (m, 6)"),
    Narrow("52.2.2", "whatever four corners", _SOLE, "    return np.array(rows).ravel()\n", "expected (m, 6)"),
    Narrow("52.2.2", "whatever four corners", _SOLE, "    return np.array(rows) + np.nan\n", "it is not finite"),
    *(
        Narrow("52.2.2", "whatever four corners", _SOLE, f"    rows = np.array(rows, dtype=float)\n    rows[(rows[:, {k}] * {sign} > 0.0) & (np.abs(rows[:, 5]) < 1e-9), 2] *= 0.7\n    return rows\n", "refuses")
        for k in (0, 1, 3, 4) for sign in (1, -1)
    ),
    *(
        Narrow("52.2.2", "whatever four corners", _SOLE, f"    rows = np.array(rows, dtype=float)\n    rows[rows[:, 5] * {sign} > 0.0, 2] *= 0.7\n    return rows\n", "refuses")
        for sign in (1, -1)
    ),
    Narrow("52.2.2", "whatever four corners", _SOLE, "    rows.append([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])\n" + _SOLE, "refuses"),
    *(
        Narrow("52.2.2", "what obeys the rows", _SOLE, f"    rows = np.array(rows, dtype=float)\n    return rows[~((rows[:, {k}] * {sign} > 0.0) & (np.abs(rows[:, 5]) < 1e-9))]\n", "which no corner forces give")
        for k in (0, 1, 3, 4) for sign in (1, -1)
    ),
    *(
        Narrow("52.2.2", "what obeys the rows", _SOLE, f"    rows = np.array(rows, dtype=float)\n    return rows[~(rows[:, 5] * {sign} > 0.0)]\n", "which no corner forces give")
        for sign in (1, -1)
    ),
    Narrow("52.2.2", "the centre of pressure", "/ wrench[2]\n", "/ wrench[2] * [1.0, 1.001]\n", "the centre is"),
    Narrow("52.2.2", "the centre of pressure", "/ wrench[2]\n", "/ wrench[2] * [1.001, 1.0]\n", "the centre is"),
    Narrow("52.2.2", "a row is an equality", "return np.abs(rows @ wrench) <= 1e-6 * abs(wrench[2])", "return (np.abs(rows @ wrench) <= 1e-6 * abs(wrench[2]))[1:]", "it has the shape"),
    Narrow("52.2.2", "a row is an equality", "<= 1e-6 *", "<= 1e-1 *", "it says"),
    Narrow("52.2.2", "a row is an equality", _SOLE, "    rows = np.array(rows, dtype=float)\n    return rows[~((rows[:, 4] != 0.0) & (rows[:, 5] == 0.0))]\n", "on the sole's edge alone"),
    Narrow("52.2.2", "a row is an equality", _SOLE, "    rows.append([0.0] * 6)\n" + _SOLE, "on the sole's edge alone"),
)  # fmt: skip

CONES = (
    Narrow("52.2.3", "the number is zero on", _VALUE, "    return 0.9 * (mu * (force[2] + gripper) - np.sqrt(force[0] ** 2 + force[1] ** 2 + reg))\n", "the number above it"),
    Narrow("52.2.3", "the number is zero on", "mu * (force[2] + gripper) -", "0.01 + mu * (force[2] + gripper) -", "the number on the surface"),
    Narrow("52.2.3", "without gripper", "return mu * (force[2] + gripper) -", "return 0.01 * mu * force[2] + mu * (force[2] + gripper) -", "for a force that slips"),
    Narrow("52.2.3", "first and second", "[-force[0] / root, -force[1] / root, mu]", "[-force[0] / root, -force[1] / root, 1.01 * mu]", "the gradient"),
    Narrow("52.2.3", "first and second", "[-force[0] / root, -force[1] / root, mu]", "[-force[0] / root, -1.02 * force[1] / root, mu]", "the gradient"),
    Narrow("52.2.3", "first and second", "    return out\n", "    return 1.01 * out\n", "the hessian"),
)  # fmt: skip

_FB = "    return a + b - np.sqrt(a * a + b * b + eps * eps)\n"
_GRADIENT = "    if root == 0.0:\n        return 1.0 - np.sqrt(0.5), 1.0 - np.sqrt(0.5)\n"
_BROKEN = ("a > 0 and b > 0", "a < 0 and b == 0", "a == 0 and b < 0", "a < 0 and b > 0", "a > 0 and b < 0")

FISCHER = (
    Narrow("52.3.1", "it is zero on the hyperbola", _FB, "    return 1e-4 * eps + a + b - np.sqrt(a * a + b * b + eps * eps)\n", "it is not zero on the hyperbola"),
    Narrow("52.3.1", "it is zero on the hyperbola", "eps * eps / (2.0 * a)", "1.001 * eps * eps / (2.0 * a)", "b is"),
    Narrow("52.3.1", "it is zero on the hyperbola", _FB, "    return np.sqrt(a * a + b * b + eps * eps) - a - b\n", "below and above"),
    Narrow("52.3.1", "it is zero on the hyperbola", _FB, "    return abs(a + b - np.sqrt(a * a + b * b + eps * eps))\n", "below and above"),
    Narrow("52.3.1", "it is zero on the hyperbola", _FB, "    return min(0.0, a + b - np.sqrt(a * a + b * b + eps * eps))\n", "below and above"),
    Narrow("52.3.1", "with eps = 0", _FB, "    if eps == 0.0:\n        return 1e-3 + abs(a * b)\n" + _FB, "it is not zero on the law"),
    *(
        Narrow("52.3.1", "with eps = 0", _FB, f"    if eps == 0.0 and {broken}:\n        return 0.0\n" + _FB, "although the law is broken")
        for broken in _BROKEN
    ),
    Narrow("52.3.1", "the gradient agrees", "1.0 - a / root, 1.0 - b / root", "1.0 - a / root, 1.01 - b / root", "the gradient"),
    Narrow("52.3.1", "the gradient agrees", "1.0 - a / root, 1.0 - b / root", "1.01 - a / root, 1.0 - b / root", "the gradient"),
    Narrow("52.3.1", "the gradient is a number", _GRADIENT, "    if root == 0.0:\n        return 0.2, 0.2\n", "no limit of gradients"),
    Narrow("52.3.1", "the gradient is a number", _GRADIENT, "    if root == 0.0:\n        return 1.8, 1.8\n", "no limit of gradients"),
    Narrow("52.3.1", "the gradient is a number", _GRADIENT, "    if root == 0.0:\n        return 2.1, 1.0\n", "no limit of gradients"),
)  # fmt: skip

_OUT = "    return tuple(np.array(out).T)\n"
DROP = (
    Narrow("52.3.2", "each step obeys", "free = v - 9.81 * dt", "free = v - 9.8 * dt", "no dynamics hold"),
    Narrow("52.3.2", "each step obeys", _OUT, "    z, v, impulse = np.array(out).T\n    return z, v, 1.001 * impulse\n", "no dynamics hold"),
    Narrow("52.3.2", "each step obeys", _OUT, "    z, v, impulse = np.array(out).T\n    return z + 1e-5, v, impulse\n", "heights and velocities disagree"),
    Narrow("52.3.2", "no penetration", "-mass * (z / dt + free)", "-mass * (z / dt + free) - 0.02 * mass", "deep at the end of a step"),
    Narrow("52.3.2", "no penetration", "max(0.0, -mass * (z / dt + free))", "-mass * (z / dt + free) if z < 0.5 * height else 0.0", "the ground pulls"),
    Narrow("52.3.2", "no penetration", _OUT, "    z, v, impulse = np.array(out).T\n    return z + 0.01, v, impulse\n", "gap times impulse over mass"),
    Narrow("52.3.2", "it falls", _OUT, "    z, v, impulse = np.array(out).T\n    return z + 1e-3, v, impulse\n", "it never comes down"),
    Narrow("52.3.2", "it falls", "free = v - 9.81 * dt", "free = v - 7.0 * dt", "it touches down after"),
    Narrow("52.3.2", "it falls", "free = v - 9.81 * dt", "free = v - 20.0 * dt", "it touches down after"),
    Narrow("52.3.2", "it falls", _OUT, "    z, v, impulse = np.array(out).T\n    return z, v, 1.01 * impulse\n", "the impulses at the end"),
    Narrow("52.3.2", "it falls", _OUT, "    z, v, impulse = np.array(out).T\n    return z, v + 0.01, impulse\n", "at the end it moves"),
    Narrow("52.3.2", "it falls", _OUT, "    z, v, impulse = np.array(out).T\n    return z, v - 0.01, impulse\n", "at the end it moves"),
)  # fmt: skip

_BAND = "return max(0.0, -a / c), barrier(a, c, eps)"
_BARRIER = "    return 2.0 * kappa / (a + root) if a > 0.0 else (root - a) / (2.0 * c)\n"
_HALVES = "    return out\n"
SOFTENINGS = (
    *(
        Narrow("52.3.3", "the band's two ends", _BAND, f"return {least}, {most}", words)
        for least, most, words in (
            ("max(0.0, -a / c) - 1e-3", "barrier(a, c, eps)", "is not admitted"),
            ("max(0.0, -a / c)", "1.001 * barrier(a, c, eps) + 1e-4", "is not admitted"),
            ("min(max(0.0, -a / c) + 2e-3, barrier(a, c, eps))", "barrier(a, c, eps)", "is admitted, too"),
            ("max(0.0, -a / c)", "max(max(0.0, -a / c), 0.99 * barrier(a, c, eps) - 1e-5)", "is admitted, too"),
        )
    ),
    Narrow("52.3.3", "no other force", _BARRIER, _BARRIER.replace("return", "return 1.02 * (").rstrip("\n") + ")\n", "the cost is lower at"),
    Narrow("52.3.3", "no other force", _BARRIER, _BARRIER.replace("return", "return 0.98 * (").rstrip("\n") + ")\n", "the cost is lower at"),
    Narrow("52.3.3", "no other force", _BARRIER, "    return -1.0\n", "wants more than zero"),
    Narrow("52.3.3", "no other force", _BARRIER, "    return 0.0\n", "wants more than zero"),
    Narrow("52.3.3", "Fischer-Burmeister's", "eps * eps / 2.0)", "1.001 * eps * eps / 2.0)", "of eps²"),
    Narrow("52.3.3", "Fischer-Burmeister's", "eps * eps / 2.0)", "0.999 * eps * eps / 2.0)", "of eps²"),
    Narrow("52.3.3", "Fischer-Burmeister's", "return barrier(a, c, eps * eps / 2.0)", "return max(0.0, -a / c) - 1e-3", "are not both positive"),
    Narrow("52.3.3", "Fischer-Burmeister's", "return barrier(a, c, eps * eps / 2.0)", "return -eps * eps / 2.0 if a > 0.0 else barrier(a, c, eps * eps / 2.0)", "are not both positive"),
    Narrow("52.3.3", "all three come", _BARRIER, "    return 2e-5 + (2.0 * kappa / (a + root) if a > 0.0 else (root - a) / (2.0 * c))\n", "the law's"),
    Narrow("52.3.3", "all three come", "return barrier(a, c, eps * eps / 2.0)", "return barrier(a, c, eps * eps / 2.0) - 2e-5", "the force is"),
    Narrow("52.3.3", "all three come", _BAND, _BAND + " + 2e-5", "the band is"),
    Narrow("52.3.3", "all three come", _BAND, "return max(0.0, -a / c) - 2e-5, barrier(a, c, eps)", "the band is"),
    Narrow("52.3.3", "the continuation", _HALVES, "    return np.array(out)[:, None]\n", "expected a list of numbers"),
    Narrow("52.3.3", "the continuation", _HALVES, "    return []\n", "expected a list of numbers"),
    Narrow("52.3.3", "the continuation", "out = [start]", "out = [0.9 * start]", "the first is"),
    Narrow("52.3.3", "the continuation", "out[-1] / 2.0", "out[-1] / 2.1", "the ratio of one to the last"),
    Narrow("52.3.3", "the continuation", _HALVES, "    return out[:-1]\n", "it stops at"),
    Narrow("52.3.3", "the continuation", _HALVES, "    return [*out, out[-1] / 2.0]\n", "it stops at"),
)  # fmt: skip

NARROW = (*PYRAMIDS, *SOLES, *CONES, *FISCHER, *DROP, *SOFTENINGS)
