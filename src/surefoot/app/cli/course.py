"""`surefoot course`: exercises of the course as stubs to fill in, checked by properties on random inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, say_verdict, show
from surefoot.base.errors import ProblemError, WriteError


def course(
    exercise: Annotated[
        str | None, typer.Argument(help="Its number, as 52.2.1; all are listed without one.")
    ] = None,
    stub: Annotated[
        Path | None, typer.Option(help="New file with the functions to write, for a start.")
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            help="Your file: run as `python FILE` would be, in a process of its own that is ended after the "
            "time limit, then its functions are tested. Nothing that is not named is run."
        ),
    ] = None,
    solution: Annotated[Path | None, typer.Option(help="New file with one solution, for afterwards.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random inputs.")] = 0,
    time_limit: Annotated[float, typer.Option(help="After which the process is ended [s].")] = 60.0,
    as_json: options.AsJson = False,
) -> int:
    """Write, check and solve the 24 exercises of the course.

    Exit code 0 if all properties hold, 1 with a line in English and one in Chinese for each that fails, and
    the input at which, 2 for a file that cannot be run and other wrong input.
    """
    from surefoot.app.course import exercises
    from surefoot.app.course.chinese import chinese
    from surefoot.app.course.grading import grade

    named = [path for path in (stub, check, solution) if path is not None]
    if len(named) > 1:
        raise ProblemError("--stub, --check and --solution are three things to do; give one of them")
    if exercise is None:
        if named:
            raise ProblemError("say which exercise, as in: surefoot course 52.2.1 --check mine.py")
        facts = [{"exercise": n, "en": en, "zh": zh} for n, (en, zh) in exercises.TITLES.items()]
        show(facts, as_json, _print_list)
        return 0
    exercises.check_number(exercise)
    if check is not None:
        findings = grade(exercise, check, seed, time_limit)
        right = all(one.holds for one in findings)
        facts_of = {"exercise": exercise, "file": str(check), "seed": seed, "right": right}
        properties = [
            vars(one) | {"words_zh": chinese(one.words), "message_zh": chinese(one.message)}
            for one in findings
        ]
        show(facts_of | {"properties": properties}, as_json, _print_grade)
        return 0 if right else 1
    out = stub or solution
    text = exercises.solution_text(exercise) if solution is not None else exercises.stub_text(exercise)
    if out is not None:
        _write(out, text)
    en, zh = exercises.TITLES[exercise]
    facts_of = {"exercise": exercise, "en": en, "zh": zh, "functions": exercises.functions_of(exercise)}
    show(facts_of | {"file": None if out is None else str(out), "text": text}, as_json, _print_exercise)
    return 0


def _write(path: Path, text: str) -> None:
    """Write a new file.

    Raises
    ------
    ProblemError
        If there is one: it may be somebody's work.
    WriteError
        If it cannot be written.
    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ProblemError(f"{path} exists already and is left as it is; name a new file") from None
    except OSError as error:
        raise WriteError(path, error) from error


def _print_list(console: Console, facts: list[dict[str, Any]]) -> None:
    say(console, *(f"{f['exercise']}  {f['en']} · {f['zh']}" for f in facts))
    say(console, "Begin: surefoot course 52.2.1 --stub mine.py, then --check mine.py in place of --stub.")


def _print_exercise(console: Console, facts: dict[str, Any]) -> None:
    if facts["file"] is None:
        say(console, facts["text"].rstrip())
    else:
        say(console, f"{facts['exercise']} {facts['en']} · {facts['zh']}")
        say(console, f"{facts['file']} has {', '.join(facts['functions'])}.")
        say(console, f"Check it: surefoot course {facts['exercise']} --check {facts['file']}")


def _print_grade(console: Console, facts: dict[str, Any]) -> None:
    for one in facts["properties"]:
        if not one["holds"]:
            at, at_zh = (f" at {one['call']}", f"（{one['call']}）") if one["call"] else ("", "")
            say(console, f'"{one["words"]}" fails{at}: {one["message"]}')
            say(console, f"不成立：“{one['words_zh']}”{at_zh}：{one['message_zh']}")
    held, total = sum(one["holds"] for one in facts["properties"]), len(facts["properties"])
    inputs = sum(one["inputs"] for one in facts["properties"])
    said = f"{facts['exercise']}: {held} of {total} properties hold, on {inputs} random inputs."
    said_zh = f"{total} 条性质中 {held} 条成立，共 {inputs} 组随机输入。"
    say_verdict(console, f"{said} {said_zh}", facts["right"])
