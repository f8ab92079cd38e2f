"""Answers that lack one property alone, or miss it narrowly, and the words that say which."""

# ruff: noqa: E501  # a table: an answer, a line

from __future__ import annotations

from typing import NamedTuple


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

_RESIDUAL = "    return gap - np.maximum(0.0, gap - r * force)\n"
_CONE = "    if gap < 0.0:\n        return False\n"
_LAWFUL = "    return in_normal_cone(-force, gap)\n"
_ERRORS = "return max(0.0, -gaps.min()), max(0.0, -forces.min()), np.abs(gaps * forces).max()"
_ALL = "for error in signorini_errors(gaps, forces))"
LAWS = (
    Narrow("52.1.1", "a force put together", "return pressing, float", "return 1.0001 * pressing, float", "(normal, tangential)"),
    Narrow("52.1.1", "a force put together", "return pressing, float(", "return pressing, 1.0001 * float(", "(normal, tangential)"),
    Narrow("52.1.1", "what is in the cone", "tangential <= mu * pressing", "tangential <= 1.05 * mu * pressing", "103%"),
    Narrow("52.1.1", "what is in the cone", "tangential <= mu * pressing", "tangential <= 0.95 * mu * pressing", "97%"),
    Narrow("52.1.1", "what is in the cone", "pressing >= 0.0 and tangential", "abs(pressing) >= 0.0 and tangential - 2.0 * mu * max(0.0, -pressing)", "it says True"),
    Narrow("52.1.1", "a weight's reaction", "np.tan(np.radians(slope))", "1.001 * np.tan(np.radians(slope))", "the friction"),
    Narrow("52.1.1", "a weight's reaction", "mu >= least_mu(slope)", "mu >= 0.97 * least_mu(slope)", "it says True"),
    Narrow("52.1.1", "a weight's reaction", "mu >= least_mu(slope)", "mu >= 1.03 * least_mu(slope)", "it says False"),
    Narrow("52.1.2", "the residual is zero where", _RESIDUAL, _RESIDUAL.rstrip("\n") + " + 1e-6\n", "the residual is"),
    *(
        Narrow("52.1.2", "the residual is not zero", _RESIDUAL, f"    if {broken}:\n        return 0.0\n" + _RESIDUAL, "pass")
        for broken in ("gap < 0 and force == 0", "gap == 0 and force < 0", "gap > 0 and force > 0", "gap < 0 and force > 0", "gap > 0 and force < 0", "gap < 0 and force < 0")
    ),
    *(
        Narrow("52.1.2", "the normal cone holds", _CONE, f"    if {where}:\n        return {value}\n" + _CONE, f"it says {value};")
        for where, value in (
            ("gap == 0 and direction > 0", True), ("gap == 0 and direction < 0", False), ("gap == 0 and direction == 0", False),
            ("gap > 0 and direction < 0", True), ("gap > 0 and direction > 0", True), ("gap > 0 and direction == 0", False), ("gap < 0", True),
        )
    ),
    *(
        Narrow("52.1.2", "the normal cone says", _LAWFUL, f"    if {where}:\n        return {value}\n" + _LAWFUL, f"it says {value}")
        for where, value in (
            ("gap == 0 and force > 0", False), ("gap == 0 and force == 0", False), ("gap > 0 and force == 0", False), ("gap < 0 and force == 0", True),
            ("gap == 0 and force < 0", True), ("gap > 0 and force > 0", True), ("gap < 0 and force > 0", True), ("gap > 0 and force < 0", True),
        )
    ),
    *(
        Narrow("52.1.3", "penetration, pull", _ERRORS, f"return tuple(np.array([{_ERRORS[7:]}]) * {factors})", "(penetration, pull, product)")
        for factors in ((1.001, 1.0, 1.0), (1.0, 1.001, 1.0), (1.0, 1.0, 1.001))
    ),
    *(
        Narrow("52.1.3", "penetration, pull", _ALL, f"for error in signorini_errors(gaps, forces)[{some}])", "it says True; the errors are")
        for some in ("1:", "0:3:2", ":1")
    ),
    Narrow("52.1.3", "penetration, pull", "return all(error <= tol", "return False and all(error <= tol", "it says False; the errors are"),
    Narrow("52.1.3", "a body at the resting", "return (1.0 - impedance)", "return 1.001 * (1.0 - impedance)", "it accelerates by"),
)  # fmt: skip

_STACK = "np.vstack([R @ local[:3], R @ local[3:]])"
_WORLD = "np.vstack([linear + np.cross(p, angular, axisb=0, axisc=0), angular])"
_HELD = "    return free + inverse @ forces, forces\n"
_RANK = "bool(np.linalg.matrix_rank(J) < len(J))"
JACOBIANS = (
    Narrow("52.4.1", "the tip", "    return np.array([lengths @", "    return 1.0001 * np.array([lengths @", "the tip is"),
    Narrow("52.4.1", "the Jacobian", "return np.cumsum(steps", "return 1.0001 * np.cumsum(steps", "the Jacobian is"),
    Narrow("52.4.1", "torques are", "return jacobian(", "return 1.0001 * jacobian(", "the vector of torques"),
    Narrow("52.4.2", "in world axes", _STACK, "np.vstack([1.001 * R @ local[:3], R @ local[3:]])", "the linear velocity, turned back"),
    Narrow("52.4.2", "in world axes", _STACK, "np.vstack([R @ local[:3], 1.001 * R @ local[3:]])", "the angular velocity, turned back"),
    Narrow("52.4.2", "WORLD is", _WORLD, _WORLD.replace(", angular])", ", 1.001 * angular])"), "the angular velocity is"),
    Narrow("52.4.2", "WORLD is", _WORLD, _WORLD.replace("[linear", "[1.01 * linear"), "the velocity at the origin"),
    Narrow("52.4.2", "WORLD is", _WORLD, _WORLD.replace("+ np.cross", "+ 1.01 * np.cross"), "the velocity at the origin"),
    Narrow("52.4.2", "the power", "return aligned(local, R)[:3].T", "return 1.001 * aligned(local, R)[:3].T", "the power of the torques"),
    Narrow("52.4.3", "M a = M free", _HELD, "    return free + inverse @ forces, np.r_[forces, 0.0]\n", "the shapes are"),
    Narrow("52.4.3", "M a = M free", _HELD, "    return np.r_[free + inverse @ forces, 0.0], forces\n", "the shapes are"),
    Narrow("52.4.3", "M a = M free", _HELD, "    return free + inverse @ forces, 1.001 * forces\n", "M (a - free)"),
    Narrow("52.4.3", "a Jacobian of full rank", "+ damping * np.eye", "+ (damping + 1e-4) * np.eye", "with full rank and no damping"),
    Narrow("52.4.3", "a Jacobian of full rank", _RANK, "True", "of full rank needs damping"),
    Narrow("52.4.3", "what damping costs", _HELD, "    return free + np.nan, forces\n", "it is not finite"),
    Narrow("52.4.3", "what damping costs", _HELD, "    return free + inverse @ forces, forces + np.nan\n", "it is not finite"),
    Narrow("52.4.3", "what damping costs", "+ damping * np.eye", "+ 1.05 * damping * np.eye", "J a is"),
    Narrow("52.4.3", "two contacts", _RANK, "False", "with a row twice needs none"),
)  # fmt: skip

_BLOCK = 'return mass * R if axes == "local" else mass * np.eye(3)'
_RATE = "    return np.r_[linear, np.cross(points - com, forces).sum(axis=0)]\n"
MOMENTA = (
    Narrow("52.5.1", "the matrix gives", "-mass * _cross(centre)", "-1.001 * mass * _cross(centre)", "the linear momentum"),
    Narrow("52.5.1", "the matrix gives", "inertia = sum(inertias)", "inertia = 1.01 * sum(inertias)", "the angular momentum"),
    Narrow("52.5.1", "the linear block", _BLOCK, _BLOCK.replace("mass * R", "1.001 * mass * R"), "block times velocity"),
    Narrow("52.5.1", "the linear block", _BLOCK, _BLOCK.replace("mass * np", "1.001 * mass * np"), "block times velocity"),
    Narrow("52.5.2", "the centre of mass", "/ masses.sum()\n", "/ masses.sum() * 1.001\n", "the first moment is"),
    Narrow("52.5.2", "spun about", "    return out\n", "    out[0, 1] += 0.01\n    return out\n", "the matrix is"),
    Narrow("52.5.2", "spun about", "    return out\n", "    return 1.001 * out\n", "the energy is"),
    Narrow("52.5.2", "moving all links", "positions - centre", "positions - 0.99 * centre", "the inertia, moved"),
    Narrow("52.5.2", "stretched legs", "    return out\n", "    return np.eye(3)\n", "has not raised it"),
    Narrow("52.5.3", "the rate is", _RATE, _RATE.replace("[linear", "[1.001 * linear"), "the rate of linear momentum"),
    Narrow("52.5.3", "the rate is", _RATE, _RATE.replace(", np", ", 1.001 * np"), "the rate of angular momentum"),
    Narrow("52.5.3", "in flight", _RATE, "    if len(points) == 0:\n        return np.r_[0.0, 0.0, -9.8 * mass, np.zeros(3)]\n" + _RATE, "the rate is"),
    Narrow("52.5.3", "in flight", _RATE, "    if len(points) == 0:\n        return np.r_[0.0, 0.0, -9.81 * mass, 0.01 * mass * np.ones(3)]\n" + _RATE, "the rate is"),
)  # fmt: skip

_TURN = "    return float(np.sum(-middle / (trunk + middle) * np.diff(angle)))\n"
_PATH = "    return np.array(loop * loops + [loop[0]])\n"
_RADIAN = "    per_radian ="
_LOOP = "    loop = [(small, -reach), (large, -reach), (large, reach), (small, reach)]\n"
_YAW = "    return float(-leg_mass * side @ speeds)\n"
FLIGHTS = (
    Narrow("52.6.1", "a body that falls", "return np.sqrt", "return 1.0001 * np.sqrt", "the way is"),
    Narrow("52.6.1", "the momentum is the sum", "return trunk * pitch_rate", "return 1.001 * trunk * pitch_rate", "the leg's rate counts from the trunk"),
    Narrow("52.6.1", "turned by", "return -legs", "return -1.001 * legs", "not zero"),
    Narrow("52.6.1", "legs that come back", "(leg_angles[-1] - leg_angles[0])", "(leg_angles[-1] - leg_angles[0]) + 1e-6", "the pitch change is"),
    Narrow("52.6.2", "the turn along", _TURN, _TURN.replace("return ", "return 1.001 * "), "the turn is"),
    Narrow("52.6.2", "a path there and back", "np.diff(angle)", "np.abs(np.diff(angle))", "the turn there and back"),
    Narrow("52.6.2", "a path there and back", _TURN, "    return 0.0\n", "turns nothing"),
    Narrow("52.6.2", "a path there and back", _TURN, _TURN.replace("float(", "abs(float(").replace("\n", ")\n"), "the turn of the loop reversed"),
    Narrow("52.6.2", "the path found", _PATH, "    return np.array(loop * loops + [loop[0]]).ravel()\n", "expected (n, 2)"),
    Narrow("52.6.2", "the path found", _PATH, "    return np.array(loop * loops + [loop[0]])[:, [0, 1, 1]]\n", "expected (n, 2)"),
    Narrow("52.6.2", "the path found", _PATH, "    return np.array(loop * 500 + [loop[0]])\n", "expected fewer than 2000"),
    *(Narrow("52.6.2", "the path found", _RADIAN, f"    {beyond}\n" + _RADIAN, "it leaves its limits") for beyond in ("small *= 0.99", "large *= 1.01", "swing *= 2.0")),
    Narrow("52.6.2", "the path found", _LOOP, "    loop = [(small, -reach), (large, reach), (small, reach)]\n", "a step changes inertia and angle at once"),
    Narrow("52.6.2", "the path found", _PATH, "    return np.array(loop * loops)\n", "it does not end in the shape"),
    Narrow("52.6.2", "the path found", "reach = -angle", "reach = -0.99 * angle", "the trunk's turn is"),
    Narrow("52.6.3", "the momentum is about", "return np.sum(", "return 1.001 * np.sum(", "the momentum is"),
    Narrow("52.6.3", "with the arms' speed", "return -leg_mass", "return -1.001 * leg_mass", "of yaw are left"),
    Narrow("52.6.3", "with the arms' speed", "return -leg_mass", "return -0.999 * leg_mass", "of yaw are left"),
    Narrow("52.6.3", "four legs", _YAW, "    return 1.001 * float(-leg_mass * side @ speeds)\n", "the yaw momentum is"),
    Narrow("52.6.3", "four legs", _YAW, "    if abs(side @ speeds) < 1e-12:\n        return 0.01\n" + _YAW, "a trot's yaw momentum"),
    Narrow("52.6.3", "four legs", _YAW, "    if np.ptp(np.abs(speeds)) < 1e-12:\n        return 0.0\n" + _YAW, "a pace has no yaw momentum"),
)  # fmt: skip

_FORCES = "    return scale * found.x.reshape(n, 3)\n"
_FIRST = "    n, m, k = len(q), len(b), len(d)\n"
_WORST = "return max(np.abs(A @ x - b).max(initial=0.0), (C @ x - d).max(initial=0.0))"
SHARES = (
    Narrow("52.7.1", "use is one", "    return np.hypot(", "    return 1.001 * np.hypot(", "the use is"),
    Narrow("52.7.1", "use is one", "np.argmax(use(forces, mu))", "np.argmin(use(forces, mu))", "the shares are"),
    Narrow("52.7.1", "the forces give", _FORCES, "    return 1.001 * scale * found.x.reshape(n, 3)\n", "their wrench"),
    Narrow("52.7.1", "the forces give", _FORCES, "    found.x[2::3] += np.array([1e-2, -1e-2, 0.0, 0.0])\n" + _FORCES, "their wrench"),
    Narrow("52.7.1", "each force is within", "-mu * np.cos(np.pi / k)", "-1.1 * mu * np.cos(np.pi / k)", "outside of its pyramid"),
    Narrow("52.7.1", "no other such", _FORCES, "    along = feet[1] - feet[0]\n    found.x[:3] += 0.3 * along\n    found.x[3:6] -= 0.3 * along\n" + _FORCES, "would do"),
    Narrow("52.7.2", "the violation is", _WORST, "return np.abs(A @ x - b).max(initial=0.0)", "the violation is"),
    Narrow("52.7.2", "the violation is", _WORST, "return (C @ x - d).max(initial=0.0)", "the violation is"),
    Narrow("52.7.2", "the violation is", _WORST, "return max((A @ x - b).max(initial=0.0), (C @ x - d).max(initial=0.0))", "the violation is"),
    Narrow("52.7.2", "the violation is", _WORST, _WORST.replace("0.0", "-9.0"), "the violation where nothing is broken"),
    Narrow("52.7.2", "the answer breaks", "    return x\n", "    return x + 1e-5\n", "a constraint is broken by"),
    Narrow("52.7.2", "the answer breaks", _FIRST, "    b = b + 1e-4\n" + _FIRST, "a constraint is broken by"),
    Narrow("52.7.2", "the answer breaks", _FIRST, "    d = d + 1e-4\n" + _FIRST, "a constraint is broken by"),
    Narrow("52.7.2", "constraints that bind", _FIRST, "    P = 1.01 * P\n" + _FIRST, "that nothing holds is"),
    Narrow("52.7.2", "constraints that bind", _FIRST, "    d = d - 1e-4\n" + _FIRST, "that nothing holds is"),
)  # fmt: skip

_SPRING = "return 1.0 / (impedance * (timeconst * dampratio) ** 2), 2.0 / (impedance * timeconst)"
_SPLITS = "    return np.array([one, one + min(one[1], one[2]) * np.array([1.0, -1.0, -1.0, 1.0])])\n"
_PRESSURE = "3.0 * cop[1] * y / half_y**2)"
SOFT = (
    Narrow("52.8.1", "a body let go", _SPRING, _SPRING.replace("return 1.0", "return -1.0"), "k and b are"),
    Narrow("52.8.1", "a body let go", _SPRING, _SPRING.replace(", 2.0", ", -2.0"), "k and b are"),
    Narrow("52.8.1", "a body let go", _SPRING, _SPRING.replace("return 1.0", "return 1.01"), "away from the motion"),
    Narrow("52.8.1", "a body let go", _SPRING, _SPRING.replace(", 2.0", ", 2.02"), "away from the motion"),
    Narrow("52.8.1", "at the resting depth", "return (1.0 - impedance)", "return 1.001 * (1.0 - impedance)", "m it is"),
    Narrow("52.8.1", "at the resting depth", "return (1.0 - impedance)", "return 0.999 * (1.0 - impedance)", "m it is"),
    Narrow("52.8.1", "the overshoot", "        return 0.0\n", "        return 0.01\n", "the motion's"),
    Narrow("52.8.1", "the overshoot", "    return float(np.exp(", "    return 0.01 + float(np.exp(", "the motion's"),
    Narrow("52.8.1", "the shortest", "2.0 * dt", "2.001 * dt", "time constant over step"),
    Narrow("52.8.2", "the pressure adds up", "mean = force", "mean = 1.001 * force", "the pressure's sum"),
    Narrow("52.8.2", "the pressure adds up", "3.0 * cop[0] * x", "3.01 * cop[0] * x", "the pressure's centre"),
    Narrow("52.8.2", "the pressure adds up", "3.0 * cop[1] * y", "3.01 * cop[1] * y", "the pressure's centre"),
    Narrow("52.8.2", "the pressure changes", _PRESSURE, "3.0 * cop[1] * y / half_y**2 + 0.1 * (x * x / half_x**2 - 1.0 / 3.0))", "the pressure between two points"),
    Narrow("52.8.2", "the whole sole", "<= 1.0 / 3.0", "<= 0.4", "it says True; the least pressure"),
    Narrow("52.8.2", "the whole sole", "<= 1.0 / 3.0", "<= 0.27", "it says False; the least pressure"),
    Narrow("52.8.2", "the whole sole", "abs(cop[0]) / half_x + abs(cop[1]) / half_y", "abs(cop[0]) / half_x", "it says True; the least pressure"),
    Narrow("52.8.2", "the whole sole", "abs(cop[0]) / half_x + abs(cop[1]) / half_y", "abs(cop[1]) / half_y", "it says True; the least pressure"),
    Narrow("52.8.2", "both splits", _SPLITS, _SPLITS.replace("one + min(", "one + 1.01 * min("), "a corner pulls"),
    Narrow("52.8.2", "both splits", _SPLITS, _SPLITS.replace("return ", "return 1.001 * "), "their sums"),
    Narrow("52.8.2", "both splits", _SPLITS, _SPLITS.replace("[1.0, -1.0, -1.0, 1.0]", "[0.5, -1.0, -0.5, 1.0]"), "their centres"),
    Narrow("52.8.2", "both splits", _SPLITS, "    return np.array([one, one])\n", "they are the same"),
)  # fmt: skip

_REACTS = "    both, n = np.r_[low, high], len(low)\n"
_TRIALS = "    return int(np.ceil(2.0 * (z * spread / difference) ** 2))\n"
_ORDER = '"".join("AB" if k else "BA" for k in first)'
_RANDOM = "np.random.default_rng(seed).integers"
_P = "    return float(np.mean(means >= abs(difference.mean()) - 1e-12))\n"
LEARNING = (
    Narrow("52.9.1", "the largest use", "return float((np.hypot", "return 1.001 * float((np.hypot", "the use is"),
    Narrow("52.9.1", "slip is", "return float(step", "return 1.001 * float(step", "the slip is"),
    Narrow("52.9.1", "slip is", "loaded[1:] & loaded[:-1]", "loaded[1:]", "the slip is"),
    Narrow("52.9.1", "slip is", "loaded[1:] & loaded[:-1]", "loaded[:-1]", "the slip is"),
    Narrow("52.9.1", "equal policies", _REACTS, "    return True\n", "at most 5 % are right"),
    Narrow("52.9.1", "a difference of three", _REACTS, "    return False\n", "that they do not differ"),
    Narrow("52.9.1", "a difference of three", _REACTS, "    if np.mean(high) < np.mean(low):\n        return False\n" + _REACTS, "that they do not differ"),
    Narrow("52.9.2", "that many trials", _TRIALS, "    return 2.0 * (z * spread / difference) ** 2\n", "expected a whole number"),
    Narrow("52.9.2", "that many trials", _TRIALS, "    return 0\n", "expected a whole number"),
    Narrow("52.9.2", "that many trials", "np.ceil(2.0 *", "np.ceil(2.8 *", "trials of each see it with"),
    Narrow("52.9.2", "that many trials", "np.ceil(2.0 *", "np.ceil(1.9 *", "trials of each see it with"),
    Narrow("52.9.2", "each pair", _ORDER, '"A" * pairs', "it has not"),
    Narrow("52.9.2", "each pair", _ORDER, "list(" + _ORDER + ")", "it has not"),
    Narrow("52.9.2", "each pair", _ORDER, _ORDER + '.replace("B", "C")', "other letters than A and B"),
    Narrow("52.9.2", "each pair", _ORDER, '"AB" * (pairs - 1) + "AA"', "has one policy twice"),
    Narrow("52.9.2", "who goes first", _ORDER, "list(" + _ORDER + ")", "it is no string"),
    Narrow("52.9.2", "who goes first", _ORDER, '"AB" * pairs', "A goes first in 200 of 200"),
    Narrow("52.9.2", "who goes first", _ORDER, '"BA" * pairs', "A goes first in 0 of 200"),
    Narrow("52.9.2", "who goes first", _RANDOM, "np.random.default_rng(0).integers", "two seeds give one order"),
    Narrow("52.9.2", "with no difference", _P, "    return 0.05\n", "below 0.1 in 300 of 300"),
    Narrow("52.9.2", "with no difference", _P, "    return 0.5\n", "below 0.1 in 0 of 300"),
    Narrow("52.9.2", "with no difference", _P, "    return 0.5 * float(np.mean(means >= abs(difference.mean()) - 1e-12))\n", "without a difference"),
    Narrow("52.9.2", "the p value", _P, "    return 1.5\n", "it is 1.5"),
    Narrow("52.9.2", "the p value", _P, "    return -0.1\n", "it is -0.1"),
    Narrow("52.9.2", "the p value", _P, "    return 0.06\n", "for a difference of three spreads"),
    Narrow("52.9.2", "the p value", _P, "    return 0.01 if difference.mean() > 0.0 else 0.04\n", "the other"),
)  # fmt: skip

NARROW = (
    *PYRAMIDS, *SOLES, *CONES, *FISCHER, *DROP, *SOFTENINGS, *LAWS, *JACOBIANS, *MOMENTA, *FLIGHTS, *SHARES, *SOFT, *LEARNING,
)  # fmt: skip
