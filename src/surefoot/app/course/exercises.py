"""The 24 exercises: their titles, and the files that students start from."""

from __future__ import annotations

import ast
from pathlib import Path

from surefoot.base.errors import ProblemError, check_name

TITLES = {
    "52.1.1": ("A foot on a slope: which friction is enough", "斜坡上的脚：多大摩擦才够"),
    "52.1.2": ("Signorini's conditions as a normal cone", "用法锥表达 Signorini 条件"),
    "52.1.3": ("MuJoCo's soft contact against Signorini", "MuJoCo 软接触与 Signorini 条件"),
    "52.2.1": ("Inner and outer pyramids against the circle", "内接与外切棱锥，对照圆"),
    "52.2.2": ("The wrench cone of a rectangular sole", "矩形鞋底的力旋量锥"),
    "52.2.3": ("OCS2's friction cone and its derivatives", "OCS2 的摩擦锥及其导数"),
    "52.3.1": ("The regularised Fischer-Burmeister function", "正则化的 Fischer-Burmeister 函数"),
    "52.3.2": ("A ball that falls, with contact left to the law", "落球：何时接触交给定律"),
    "52.3.3": ("Three softenings of one contact", "一个接触的三种软化"),
    "52.4.1": ("A planar arm's Jacobian by hand", "手写平面机械臂的雅可比"),
    "52.4.2": ("One Jacobian in three frames", "三种坐标系中的雅可比"),
    "52.4.3": ("Contact in the forward dynamics, and damping", "前向动力学中的接触与阻尼"),
    "52.5.1": ("The base's columns of the momentum matrix", "动量矩阵的基座列"),
    "52.5.2": ("The composite inertia", "复合惯量"),
    "52.5.3": ("The rate of the centroidal momentum", "质心动量的变化率"),
    "52.6.1": ("A fall that arrives pitched", "落地时的俯仰"),
    "52.6.2": ("A cat of two bodies", "两体落猫"),
    "52.6.3": ("Arms that cancel yaw", "摆臂抵消偏航"),
    "52.7.1": ("One wrench shared over feet by facets", "用棱面把一个力旋量分配到各脚"),
    "52.7.2": ("A quadratic program, solved accurately", "精确求解二次规划"),
    "52.8.1": ("MuJoCo's solref: depth and oscillation", "MuJoCo 的 solref：压深与振荡"),
    "52.8.2": ("Pressure under a sole, and rigid corners", "鞋底压力与刚性角点"),
    "52.9.1": ("A policy on two frictions: use, slip, reaction", "两种摩擦下的策略：用量、滑移、反应"),
    "52.9.2": ("An experiment that compares two policies", "比较两个策略的实验设计"),
}
"""Number to the title in English and in Chinese."""
PACKAGE = Path(__file__).resolve().parents[2]
PLACES = (PACKAGE / "solutions", PACKAGE.parents[1] / "course" / "solutions")
"""Where solutions are: in an installed package, in a checkout."""


def check_number(number: str) -> None:
    """Refuse what is no exercise.

    Raises
    ------
    ProblemError
        With the nearest number.
    """
    check_name("exercise", number, TITLES)


def solution_text(number: str) -> str:
    """Return the Python file of a solution.

    Raises
    ------
    ProblemError
        If the number is none, or this installation has no solutions.
    """
    check_number(number)
    for place in PLACES:
        if (path := place / f"{number}.py").is_file():
            return path.read_text(encoding="utf-8")
    raise ProblemError("this installation has no exercises; a checkout and a wheel have them")


def stub_text(number: str) -> str:
    """Return the file that a student starts from: what to write, and nothing of how.

    Of a solution it has the head, and each public function with its docstring alone.

    Raises
    ------
    ProblemError
        As `solution_text`.
    """
    text = solution_text(number)
    lines, tree = text.splitlines(), ast.parse(text)
    head = ast.get_docstring(tree, clean=False) or ""
    out = [
        f'"""{head.rstrip()}\n\nsurefoot course {number} --check THIS_FILE tells which property fails.\n"""'
    ]
    out += ["", "import numpy as np"]
    for part in tree.body:
        if isinstance(part, ast.FunctionDef) and not part.name.startswith("_"):
            out += [
                "",
                "",
                *lines[part.lineno - 1 : part.body[0].end_lineno],
                "    raise NotImplementedError",
            ]
    return "\n".join(out) + "\n"


def functions_of(number: str) -> list[str]:
    """Return the names of the functions that an exercise asks for.

    Raises
    ------
    ProblemError
        As `solution_text`.
    """
    body = ast.parse(solution_text(number)).body
    return [p.name for p in body if isinstance(p, ast.FunctionDef) and not p.name.startswith("_")]
