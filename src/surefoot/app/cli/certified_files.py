"""Motions of files certified on all cores, each kept in a folder as soon as it is done."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from surefoot.app.cli.processes import results_of
from surefoot.base.errors import ProblemError, SurefootError, one_line, writing

if TYPE_CHECKING:
    from surefoot.records.certificates.motion_report import MotionReport
    from surefoot.records.motions.motion import Motion


@dataclass(frozen=True)
class Question:
    """What is asked of every file; see `certify_motion` and `read_motion`."""

    robot: str
    fps: float | None
    order: Any
    quaternion: str | None
    mu: float
    sliding_mu: tuple[float, float]
    window: float | None
    terrain: str | None
    picture: str | None = None
    repair: str | None = None


@dataclass(frozen=True)
class Outcome:
    """A motion's report as plain values, whether it was kept from before, or why there is none."""

    file: str
    facts: dict[str, Any]
    kept: bool = False
    error: str | None = None


def certify_files(
    files: Sequence[Path],
    question: Question,
    folder: Path | None,
    jobs: int | None,
    show: Callable[[float], None] | None,
) -> list[Outcome]:
    """Return the outcomes of files in their order; `show` is given how many are done.

    With a folder every motion leaves a .json and a .csv there, named by its file, its key and what was asked;
    those that are there are read and not certified anew.
    """
    for place in (folder, None if question.repair is None else Path(question.repair)):
        if place is not None:
            with writing(place):
                place.mkdir(parents=True, exist_ok=True)
    out: dict[int, list[Outcome]] = {}
    tasks = [(path, question, folder) for path in files]
    for k, found in results_of(certify_file, tasks, jobs):
        out[k] = found
        if show is not None:
            show(float(len(out)))
    return [one for k in range(len(files)) for one in out[k]]


def certify_file(path: Path, question: Question, folder: Path | None) -> list[Outcome]:
    """Return the outcomes of one file, one for each motion in it; one with the error where it is wrong."""
    try:
        kept = None if folder is None else _place(path, question, folder)
        if kept is not None and kept.with_suffix(".json").exists():
            facts = json.loads(kept.with_suffix(".json").read_text(encoding="utf-8"))
            return [Outcome(str(path), one, kept=True) for one in facts]
        return [Outcome(str(path), one) for one in _certify(path, question, kept)]
    except SurefootError as error:
        said = one_line(error)
        return [Outcome(str(path), {}, error=said if str(path) in said else f"{path}: {said}")]


def _place(path: Path, question: Question, folder: Path) -> Path:
    """Return where the report of a file stands, by its contents, what is asked and the rules of today."""
    from surefoot.records.certificates.certificate_settings import CertificateSettings

    try:
        contents = path.read_bytes()
    except OSError as error:
        raise ProblemError(f"{path}: {error.strerror or error}") from error
    asked = json.dumps([asdict(question), asdict(CertificateSettings())], sort_keys=True).encode()
    return folder / f"{path.stem}-{hashlib.sha256(contents + asked).hexdigest()[:8]}"


def _certify(path: Path, question: Question, kept: Path | None) -> list[dict[str, Any]]:
    """Certify the motions of a file and keep what is found."""
    from surefoot.app.cli import robots
    from surefoot.mechanics import read_terrain
    from surefoot.records.certificates.certify import certify_motion
    from surefoot.records.motions.read_motion import read_motions

    robot = robots.load(question.robot)
    ground = None if question.terrain is None else read_terrain(question.terrain, "--terrain")
    found = []
    for motion in read_motions(path, robot, question.fps, question.order, question.quaternion):
        report = certify_motion(robot, motion, question.mu, question.sliding_mu, ground, question.window)
        found.append(report.plain())
        if question.repair is not None:
            found[-1]["mended"] = _mend(report, path, len(found), question)
        if kept is not None:
            number = "" if len(found) == 1 else f"-{len(found)}"
            rows = kept.with_name(f"{kept.name}{number}.csv")
            rows.unlink(missing_ok=True)  # of a run that was interrupted before its .json
            report.to_csv(rows)
        if question.picture is not None:
            from surefoot.app.viz.picture import picture

            picture(report, question.picture)
    if kept is not None:
        with writing(kept):
            kept.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return found


def _mend(report: MotionReport, path: Path, number: int, question: Question) -> dict[str, Any]:
    """Write the mended motion into the folder of repairs and return what became of it."""
    from surefoot.records.repairs.repair_motion import repair_motion

    mended = repair_motion(report)
    place = _place(path, question, Path(str(question.repair)))
    place = place.with_name(f"{place.name}{'' if number == 1 else f'-{number}'}.npz")
    return {
        "file": str(_write_new(mended.motion, place)),
        "verdict": mended.report.verdict,
        "impossible_share": mended.report.impossible_share,
        "mended": mended.mended,
        "joint_change": mended.joint_change,
        "base_change": mended.base_change,
        "duration": mended.motion.duration,
        "sentence": str(mended),
    }


def _write_new(motion: Motion, place: Path) -> Path:
    """Write a motion and return where: under the next free name if another file has the one that is meant."""
    with writing(place), TemporaryDirectory(dir=place.parent) as folder:
        made, number, free = motion.to_npz(Path(folder) / place.name), 1, place
        while free.exists() and free.read_bytes() != made.read_bytes():  # not of an earlier run
            number += 1
            free = place.with_stem(f"{place.stem}-again-{number}")
        return made.replace(free)
