"""A robot on Pinocchio: model, feet, limits, and the stance it takes on a terrain."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, per_contact
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ModelError, ProblemError, unknown_name
from surefoot.base.libraries import import_pinocchio
from surefoot.mechanics.robot import catalog
from surefoot.mechanics.robot.contact_points import ContactPoints, contact_points
from surefoot.mechanics.robot.foot import Foot, frame_names
from surefoot.mechanics.robot.mjcf import check_base, is_mjcf, nominal_of, read_mjcf
from surefoot.mechanics.robot.shape_loading import ShapesOfFile, mjcf_shapes, urdf_shapes
from surefoot.mechanics.stance import Contact, PointContact, SoleContact, Stance
from surefoot.mechanics.terrain import FlatTerrain, Terrain

if TYPE_CHECKING:
    from surefoot.mechanics.robot.lint import Lint


class Robot(Drawn, ShapesOfFile):
    """A robot model with feet; built by `load_robot`.

    Configurations follow Pinocchio: q = [base position (3); base quaternion (x, y, z, w); joints],
    v = [base linear; base angular velocity, both in base axes; joints] for a floating base, and the
    joints alone for a fixed one.

    Attributes
    ----------
    name
        What it was loaded as.
    model, data
        Pinocchio's Model and a Data of our own; write to neither.
    collision, visual
        Pinocchio's geometry models; the visual one is read from its files when first asked for.
    feet
        Where it can touch the ground, see `Foot`.
    nominal
        (nq,) the pose to stand in [m, -, rad], at the height where the feet touch z = 0.
    floating
        Whether the base is free.
    missing_meshes
        Files of collision meshes that are not there, by link; what else the robot has is as its file says.
    notes
        How the feet of a robot's own file were read, and what is missing, in lines; none for known robots.
    source
        The file that it was loaded from.
    """

    source: Path | None = None
    described = False  # whether its feet are the catalogue's, and not read from its shapes

    def __init__(
        self,
        name: str,
        model: Any,
        collision: Any,
        visual: Callable[[], Any],
        feet: Sequence[Foot],
        nominal: FloatArray,
        floating: bool,
        missing_meshes: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        self.name, self.model, self.collision, self._load_visual = name, model, collision, visual
        self.floating = floating
        self.nominal = nominal
        self.feet = tuple(feet)
        self.missing_meshes = dict(missing_meshes or {})
        self.notes: tuple[str, ...] = ()
        if floating and self.feet:
            self.nominal = nominal.copy()
            self.nominal[2] -= min(self.sphere_bottoms(nominal))

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, mass={self.mass:.3f}, joints={self.joints}, feet={self.foot_names})"

    def __str__(self) -> str:
        base = "floating" if self.floating else "fixed"
        feet = ", ".join(self.foot_names) or "none"
        return f"{self.name}: {self.mass:.4g} kg, {self.joints} joints, {base} base; feet: {feet}."

    @cached_property
    def data(self) -> Any:
        """Pinocchio's Data of our own; of many joints it is large, so it is made when asked for."""
        return self.model.createData()

    @cached_property
    def visual(self) -> Any:
        """Pinocchio's geometry model of what the robot looks like."""
        return self._load_visual()

    @cached_property
    def contact_points(self) -> ContactPoints:
        """The contact spheres of all feet as one value: where they are, what carries and moves them."""
        return contact_points(self.model, self.feet)

    @cached_property
    def mass(self) -> float:
        """Total mass [kg]."""
        import pinocchio

        return float(pinocchio.computeTotalMass(self.model))

    @property
    def base_dof(self) -> int:
        """Velocity components of the base: 6 floating, 0 fixed."""
        return 6 if self.floating else 0

    @property
    def joints(self) -> int:
        """Number of actuated velocity components."""
        return int(self.model.nv) - self.base_dof

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the actuated joints, in the model's order."""
        names = list(self.model.names)[1:]
        return tuple(names[1:] if self.floating else names)

    @cached_property
    def array_shapes(self) -> tuple[tuple[int], tuple[int], tuple[int], tuple[int], tuple[int, int]]:
        """Shapes of its arrays: q, v, which feet touch, joint torques, forces on its feet."""
        feet = len(self.feet)
        return (int(self.model.nq),), (int(self.model.nv),), (feet,), (self.joints,), (feet, 3)

    @property
    def foot_names(self) -> tuple[str, ...]:
        """Names of the feet, in order."""
        return tuple(f.name for f in self.feet)

    @cached_property
    def effort_limits(self) -> FloatArray:
        """(joints,) torque limits of the URDF [N m]; infinite where it gives none."""
        return self._limits(self.model.upperEffortLimit)

    @cached_property
    def speed_limits(self) -> FloatArray:
        """(joints,) speed limits of the URDF [rad/s, m/s]; infinite where it gives none."""
        return self._limits(self.model.upperVelocityLimit)

    def _limits(self, values: Any) -> FloatArray:
        """Return the joints' part of the model's (nv,) limits, infinite where it gives none."""
        limits = np.array(values, dtype=np.float64)[self.base_dof :]
        return np.where((limits <= 0.0) | (limits > 1e100), np.inf, limits)

    def foot(self, name: str) -> Foot:
        """Return a foot by name.

        Raises
        ------
        ModelError
            If there is no such foot; the message lists them.
        """
        for foot in self.feet:
            if foot.name == name or foot.name.lower().removesuffix("_foot") == name.lower():
                return foot
        raise ModelError(unknown_name(f"foot of {self.name}", name, self.foot_names))

    def configuration(self, q: ArrayLike | None = None) -> FloatArray:
        """Return q checked (nominal for None), its quaternion normalised: (nq,) [m, -, rad]."""
        if q is None:
            return self.nominal.copy()
        out = finite_array("q", q, (self.model.nq,))
        if self.floating:
            length = float(np.linalg.norm(out[3:7]))
            if abs(length - 1.0) > 1e-3:
                raise ProblemError(f"q[3:7] must be a unit quaternion (x, y, z, w), its length is {length:g}")
            out[3:7] /= length
        return out

    def lint(self) -> Lint:
        """Return what in the file of the model would make a walk or a verdict wrong; see docs/lint.md.

        Raises
        ------
        ModelError
            For a robot that was not loaded from a file.
        """
        if self.source is None:
            raise ModelError(f"{self.name} was not loaded from a file, and the lint reads files")
        from surefoot.mechanics.robot.lint.lint import lint_robot

        return lint_robot(self, self.source, self.described)

    def com(self, q: ArrayLike | None = None) -> FloatArray:
        """Return the centre of mass in world axes [m]: (3,)."""
        import pinocchio

        return np.array(pinocchio.centerOfMass(self.model, self.data, self.configuration(q)))

    def foot_positions(self, q: ArrayLike | None = None) -> FloatArray:
        """Return the feet's sphere centres (sole centres if flat) in world axes [m]: (n, 3)."""
        self._forward(self.configuration(q))
        places = [self.data.oMf[f.frame].act(f.centre) for f in self.feet]
        return np.array(places).reshape(-1, 3)

    def stance(
        self,
        q: ArrayLike | None = None,
        mu: float | Sequence[float] = 0.6,
        terrain: Terrain | None = None,
        feet: str | Sequence[str] | None = None,
        normal_min: float = 0.0,
        normal_max: float = math.inf,
    ) -> Stance:
        """Return the stance of the feet at a configuration, on the terrain below them.

        The contact of a foot is where its sphere (or sole) meets the terrain's tangent plane; its
        frame follows the terrain, never the foot.

        Parameters
        ----------
        q
            (nq,) [m, -, rad]; None for the nominal pose.
        mu
            Friction coefficient [-], one or one per foot.
        terrain
            None for flat ground.
        feet
            Names of the feet that touch, in a list or between commas; None for all.
        normal_min, normal_max
            Bounds on each normal force [N].
        """
        ground = FlatTerrain() if terrain is None else terrain
        names = frame_names(feet)
        chosen = self.feet if names is None else tuple(self.foot(name) for name in names)
        of_kind("terrain", ground, Terrain)
        frictions = per_contact("mu", mu, len(chosen))
        self._forward(self.configuration(q))
        contacts: list[Contact] = []
        for foot, friction in zip(chosen, frictions, strict=True):
            pose = self.data.oMf[foot.frame]
            place = pose.act(foot.centre)
            normal = ground.normal(place[:2])
            point = place - foot.radius * normal
            shared = (foot.name, normal_min, normal_max)
            if foot.flat:  # its toes say where the sole's x axis points
                sole = foot.sole(float(friction))
                contacts.append(SoleContact(point, sole, normal, *shared, pose.rotation[:, 0]))
            else:
                contacts.append(PointContact(point, normal, float(friction), *shared))
        return Stance(contacts)

    def _forward(self, q: FloatArray) -> None:
        import pinocchio

        pinocchio.framesForwardKinematics(self.model, self.data, q)

    def sphere_bottoms(self, q: FloatArray) -> list[float]:
        """Return the lowest height of every contact sphere [m] at q (nq,) [m, -, rad]."""
        self._forward(q)
        return [float(self.data.oMf[f.frame].act(c)[2]) - f.radius for f in self.feet for c in f.centres]


def load_robot(
    robot: str | Path, feet: str | Sequence[str] | None = None, *, fixed_base: bool | None = None
) -> Robot:
    """Load a robot by name, or from a URDF or MJCF file.

    Parameters
    ----------
    robot
        A name from `robot_names`, or the path of a URDF or MJCF file.
    feet
        Frames that can touch the ground, in one text separated by commas or one by one; None for the
        catalogue's choice (none for a file). Of an MJCF file bodies, sites and named shapes are frames.
    fixed_base
        Whether the base is bolted to the world; None for the catalogue's choice (free for a URDF file; as its
        free joint says for an MJCF file).

    Raises
    ------
    ModelError
        For an unknown name, a missing or broken file, or feet that are not frames of the robot.
    MissingExtra
        If Pinocchio is not installed, or for an MJCF file MuJoCo.

    Examples
    --------
    >>> robot = load_robot("go2")
    >>> round(robot.mass, 3), robot.foot_names
    (16.085, ('FL_foot', 'FR_foot', 'RL_foot', 'RR_foot'))
    """
    from surefoot.mechanics.robot.foot_reading import FootSource, reading_notes
    from surefoot.mechanics.robot.nominal_pose import feet_and_pose, file_pose
    from surefoot.mechanics.robot.urdf import parse_urdf
    from surefoot.mechanics.robot.urdf_geometry import urdf_geometry
    from surefoot.mechanics.robot.urdf_ranges import whole_turns

    feet = frame_names(feet)
    text = str(robot)
    is_own = text.lower().endswith((".urdf", ".xml")) or "/" in text
    if is_own:
        path, entry, srdf = Path(text).expanduser(), catalog.CatalogEntry(text), None
        folders = [path.parent, *path.resolve().parents]
        if not path.is_file():
            raise ModelError(f"no {'file' if text.lower().endswith('.xml') else 'URDF file'} at {text}")
        from surefoot.mechanics.robot.model_size import check_size

        check_size(path)
        if is_mjcf(path):
            return _from_mjcf(path, tuple(feet or ()), fixed_base)
    else:
        entry, root = catalog.find(text), catalog.robots_folder()
        path, srdf = root / entry.urdf, root / entry.srdf if entry.srdf else None
        folders = [root, root.parent.parent]
    chosen = entry.feet if feet is None else tuple(feet)
    fixed = entry.fixed_base if fixed_base is None else fixed_base
    pinocchio = import_pinocchio()
    changed, ranged = whole_turns(path, chosen) if is_own else ("", ())
    model = parse_urdf(path, [] if fixed else [pinocchio.JointModelFreeFlyer()], changed)
    collision, missing = urdf_geometry(model, path, pinocchio.GeometryType.COLLISION, folders)
    _mend_limits(model, entry)
    _check_feet(model, chosen, path)
    name = path.stem if path.suffix and "/" in text else text

    load = partial(urdf_shapes, model, path.resolve(), [folder.resolve() for folder in folders])
    visual = partial(load, "VISUAL")
    source = FootSource(model, collision, visual, missing)
    found, nominal = feet_and_pose(source, chosen, file_pose(model, srdf, entry), fixed, entry)
    out = Robot(name, model, collision, visual, found, nominal, not fixed, missing)
    out.notes = reading_notes(found, missing, ranged) if is_own else ()
    out.source, out.described = path, bool(entry.shapes) and set(chosen) <= set(entry.feet)
    out.keep_file(path, partial(load, "COLLISION"))
    return out


def _mend_limits(model: Any, entry: catalog.CatalogEntry) -> None:
    """Give joints the limits of the catalogue, where it has better ones than the file."""
    for joint, title in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        if entry.unlimited and title.startswith(entry.unlimited):
            model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q] = -np.pi, np.pi
        if entry.effort and joint.nv == 1:
            k = joint.idx_v
            model.lowerEffortLimit[k], model.upperEffortLimit[k] = -entry.effort, entry.effort
            model.lowerVelocityLimit[k], model.upperVelocityLimit[k] = -entry.speed, entry.speed


def _from_mjcf(path: Path, feet: Sequence[str], fixed_base: bool | None) -> Robot:
    """Return the robot of an MJCF file, in its first keyframe that is a nominal pose."""
    from surefoot.mechanics.robot.foot_reading import FootSource, reading_notes
    from surefoot.mechanics.robot.nominal_pose import FOLDED, feet_and_pose

    read = read_mjcf(path, fixed_base)
    if feet and fixed_base is None:
        check_base(read, path)
    _check_feet(read.model, feet, path)

    load, entry = partial(mjcf_shapes, path.resolve(), fixed_base), catalog.CatalogEntry(str(path))
    missing = read.missing_meshes
    source = FootSource(read.model, read.collision, load, missing)
    pose = nominal_of(read.poses)
    found, nominal = feet_and_pose(source, feet, pose, not read.floating, entry)
    out = Robot(path.stem, read.model, read.collision, load, found, nominal, read.floating, missing)
    unlike = () if pose is None or np.array_equal(pose, nominal) else (FOLDED,)
    out.notes = (*reading_notes(found, missing), *unlike)
    out.source = path
    out.keep_file(path, load)
    return out


def _check_feet(model: Any, feet: Sequence[str], path: Path) -> None:
    """Refuse feet that are no frames, or twice the same."""
    frames = [f.name for f in model.frames]
    for name in feet:
        if name not in frames:
            bodies = [f.name for f in model.frames if f.type.name in ("BODY", "OP_FRAME")]
            raise ModelError(unknown_name(f"foot frame of {path.name}", name, bodies))
    if len(set(feet)) != len(feet):
        raise ModelError(f"feet must differ, got {', '.join(feet)}")
