"""A robot on Pinocchio: model, feet, Jacobians, dynamics."""

from surefoot.mechanics.robot.catalog import robot_names
from surefoot.mechanics.robot.contact_points import ContactPoints
from surefoot.mechanics.robot.foot import Foot
from surefoot.mechanics.robot.placement import place
from surefoot.mechanics.robot.robot import Robot, load_robot

__all__ = ["ContactPoints", "Foot", "Robot", "load_robot", "place", "robot_names"]
